//! The filter of a lateral position: a Kalman filter whose noise follows what it sees.
//!
//! State [y, w]: position, m, and speed, m/s; between two scans a constant acceleration, unknown with
//! standard deviation `a`:
//!
//! ```text
//! y += T w                      P += a² [T⁴/4  T³/2]
//! w += e                                [T³/2  T²  ]
//! ```
//!
//! A vehicle keeps its lane most of the time, and then changes it: `a` is [`STEADY_MPS2`] until the
//! normalised innovations have a mean ([`MEMORY`]) beyond [`BIASED`], and [`MOVING_MPS2`] while they have.
//!
//! Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
//! 6.3.2 (white noise acceleration) and 11.2 (adjustable level of the process noise).

/// Standard deviation of the lateral acceleration of a vehicle that keeps its lane, m/s².
const STEADY_MPS2: f64 = 1.0;
/// That of one that changes it, m/s².
const MOVING_MPS2: f64 = 2.0;
/// Share of the mean of the innovations that a scan leaves.
const MEMORY: f64 = 0.8;
/// Mean of the normalised innovations from which the vehicle is taken to change its lane.
const BIASED: f64 = 0.7;
/// Standard deviation of the lateral speed of a new vehicle, m/s.
const FIRST_SPEED_SIGMA_MPS: f64 = 1.0;
/// A measurement is limited to this many standard deviations.
const LIMIT_SIGMA: f64 = 3.0;

/// A lateral position with its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lateral {
    /// Position, m, left positive.
    pub position_m: f64,
    /// Rate, m/s.
    pub rate_mps: f64,
    /// Variances of the position, m², and of the rate, m²/s², and their covariance, m²/s.
    variances: [f64; 3],
    /// Mean of the last normalised innovations.
    bias: f64,
}

impl Lateral {
    /// A motion that is known.
    #[must_use]
    pub fn known(position_m: f64, rate_mps: f64) -> Self {
        Self { position_m, rate_mps, ..Self::default() }
    }

    /// A motion of which one measurement is known, with its standard deviation, m.
    #[must_use]
    pub fn first(position_m: f64, sigma_m: f64) -> Self {
        let variances = [sigma_m * sigma_m, FIRST_SPEED_SIGMA_MPS * FIRST_SPEED_SIGMA_MPS, 0.0];
        Self { position_m, variances, ..Self::default() }
    }

    /// Standard deviation of the position, m.
    #[must_use]
    pub fn position_sigma_m(&self) -> f64 {
        self.variances[0].max(0.0).sqrt()
    }

    /// Standard deviation of the rate, m/s.
    #[must_use]
    pub fn rate_sigma_mps(&self) -> f64 {
        self.variances[1].max(0.0).sqrt()
    }

    /// Where it is `time_s` later if it keeps its rate; what is known of it stays.
    pub fn move_on(&mut self, time_s: f64) {
        self.position_m += self.rate_mps * time_s;
    }

    /// Moves on by `period_s`, in which it may change its rate.
    pub fn predict(&mut self, period_s: f64) {
        self.move_on(period_s);
        let sigma = if self.bias.abs() > BIASED { MOVING_MPS2 } else { STEADY_MPS2 };
        let gain = sigma * period_s;
        let [position, rate, both] = &mut self.variances;
        *position += period_s * (2.0 * *both + period_s * *rate);
        *both += period_s * *rate;
        *position += 0.25 * gain * gain * period_s * period_s;
        *both += 0.5 * gain * gain * period_s;
        *rate += gain * gain;
    }

    /// Takes a measured position with its variance, m², at the time predicted to.
    pub fn update(&mut self, measured_m: f64, variance_m2: f64) {
        let spread_m2 = self.variances[0] + variance_m2;
        let limit_m = LIMIT_SIGMA * spread_m2.sqrt();
        let miss_m = (measured_m - self.position_m).clamp(-limit_m, limit_m);
        self.bias = MEMORY * self.bias + (1.0 - MEMORY) * miss_m / spread_m2.sqrt();
        let [position, rate, both] = self.variances;
        let gains = [position / spread_m2, both / spread_m2];
        self.position_m += gains[0] * miss_m;
        self.rate_mps += gains[1] * miss_m;
        self.variances =
            [position * (1.0 - gains[0]), rate - gains[1] * both, both * (1.0 - gains[0])];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.05;

    /// Repeatable errors with a standard deviation of about 1.
    fn error(k: u32) -> f64 {
        let mixed = u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        (mixed as f64 / f64::from(1 << 24) - 0.5) * 12f64.sqrt()
    }

    /// Follows a motion measured with `sigma_m`; calls back after each scan.
    fn follow(sigma_m: f64, motion: impl Fn(f64) -> f64, mut see: impl FnMut(f64, &Lateral)) {
        let mut filter = Lateral::first(motion(0.0) + sigma_m * error(0), sigma_m);
        for k in 1..400 {
            let time_s = f64::from(k) * PERIOD_S;
            filter.predict(PERIOD_S);
            filter.update(motion(time_s) + sigma_m * error(k), sigma_m * sigma_m);
            see(time_s, &filter);
        }
    }

    #[test]
    fn a_vehicle_in_its_lane_has_little_lateral_speed_and_says_how_little() {
        let (mut squares, mut believed, mut count) = (0.0, 0.0, 0.0);
        follow(
            0.08,
            |_| 3.5,
            |time_s, filter| {
                if time_s > 2.0 {
                    squares += filter.rate_mps * filter.rate_mps;
                    believed += filter.variances[1];
                    count += 1.0;
                }
            },
        );
        assert!(f64::sqrt(squares / count) < 0.15, "{}", squares / count);
        assert!(believed > squares, "it claims no more than it knows: {believed} {squares}");
    }

    #[test]
    fn a_lane_change_is_seen_within_two_fifths_of_a_second() {
        let mut seen_s = f64::INFINITY;
        let motion = |time_s: f64| 3.5 - 1.2 * (time_s - 5.0).max(0.0);
        follow(0.08, motion, |time_s, filter| {
            if time_s > 5.0 && filter.rate_mps < -0.6 {
                seen_s = seen_s.min(time_s - 5.0);
            }
        });
        assert!(seen_s < 0.41, "{seen_s} s");
    }

    #[test]
    fn one_wild_position_moves_it_little() {
        let mut filter = Lateral::first(0.0, 0.1);
        for _ in 0..100 {
            filter.predict(PERIOD_S);
            filter.update(0.0, 0.01);
        }
        filter.update(50.0, 0.01);
        assert!(filter.position_m < 0.3, "{filter:?}");
    }
}
