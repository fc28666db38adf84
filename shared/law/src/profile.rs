//! The speeds that the road ahead allows.

/// Time in which a speed above the profile's is braked off, s. Chosen: ten periods, so that noise of the curvature makes
/// no jerk.
const SETTLE_S: f64 = 1.0;
/// Time until a request acts, s: a control period, the links and half of the brake's rise.
pub const RESPONSE_S: f64 = 0.4;
/// Least way on which a speed changes, m. Chosen: the noise of a speed near standstill is no braking.
const LEAST_M: f64 = 2.0;

/// Largest speeds from the ego's front bumper on, at places [`Self::STEP_M`] apart.
///
/// Between two places the speed changes with a constant acceleration: its square is linear.
///
/// ```
/// use law::SpeedProfile;
///
/// let mut profile = SpeedProfile::constant(30.0);
/// profile.cap(200.0, 250.0, 10.0, 1.0);
/// profile.brake(1.0);
/// assert_eq!(profile.at_mps(200.0), 10.0);
/// assert!((profile.at_mps(150.0) - f64::sqrt(100.0 + 2.0 * 50.0)).abs() < 1e-9);
/// assert_eq!(profile.at_mps(300.0), 30.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedProfile {
    squares: [f64; Self::PLACES],
}

impl SpeedProfile {
    pub const STEP_M: f64 = 5.0;
    /// 400 m: the way of the laws' horizon at 40 m/s.
    pub const PLACES: usize = 81;

    /// One speed all along, m/s.
    pub fn constant(speed_mps: f64) -> Self {
        Self { squares: [speed_mps * speed_mps; Self::PLACES] }
    }

    /// Caps the speed on a stretch, m ahead. A stretch behind the last place counts there, by what a braking in m/s²
    /// takes off on the way.
    pub fn cap(&mut self, from_m: f64, to_m: f64, speed_mps: f64, braking_mps2: f64) {
        let last_m = Self::STEP_M * (Self::PLACES - 1) as f64;
        let square = speed_mps * speed_mps + 2.0 * braking_mps2 * (from_m - last_m).max(0.0);
        let place = |ahead_m: f64| (ahead_m.clamp(0.0, last_m)) / Self::STEP_M;
        let (from, to) = (place(from_m) as usize, place(to_m).ceil() as usize);
        self.squares[from..=to].iter_mut().for_each(|known| *known = known.min(square));
    }

    /// Lowers the speeds before each cap, so that a braking in m/s² comes down to it.
    pub fn brake(&mut self, braking_mps2: f64) {
        for place in (1..Self::PLACES).rev() {
            let before = self.squares[place] + 2.0 * braking_mps2 * Self::STEP_M;
            self.squares[place - 1] = self.squares[place - 1].min(before);
        }
    }

    /// The speed at a place, m/s; behind the last place it is the last speed.
    pub fn at_mps(&self, ahead_m: f64) -> f64 {
        self.square(ahead_m).sqrt()
    }

    /// The lowest speed that acts on an ego of this speed at a place, m/s: on its way until a request has settled.
    pub fn lowest_mps(&self, ahead_m: f64, speed_mps: f64) -> f64 {
        let end_m = ahead_m + (SETTLE_S + RESPONSE_S) * speed_mps;
        let place = |ahead_m: f64| ((ahead_m / Self::STEP_M) as usize).min(Self::PLACES - 1);
        let between = &self.squares[(place(ahead_m) + 1).min(place(end_m))..=place(end_m)];
        let ends = self.square(ahead_m).min(self.square(end_m));
        between.iter().copied().fold(ends, f64::min).sqrt()
    }

    /// The acceleration that brings an ego of this speed at a place to the profile, m/s².
    pub fn most_mps2(&self, ahead_m: f64, speed_mps: f64) -> f64 {
        let lowest_mps = self.lowest_mps(ahead_m, speed_mps);
        let surplus = lowest_mps * lowest_mps - speed_mps * speed_mps;
        surplus / (2.0 * (SETTLE_S * speed_mps).max(LEAST_M))
    }

    fn square(&self, ahead_m: f64) -> f64 {
        let place = (ahead_m / Self::STEP_M).clamp(0.0, (Self::PLACES - 1) as f64);
        let low = (place as usize).min(Self::PLACES - 2);
        self.squares[low] + (place - low as f64) * (self.squares[low + 1] - self.squares[low])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_beyond_the_last_place_is_braked_for_within_it() {
        let mut profile = SpeedProfile::constant(40.0);
        profile.cap(700.0, 800.0, 10.0, 1.0);
        profile.brake(1.0);
        assert!((profile.at_mps(400.0) - 700.0_f64.sqrt()).abs() < 1e-9);
        assert!((profile.at_mps(0.0) - 1500.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(profile.at_mps(500.0), profile.at_mps(400.0));
    }

    #[test]
    fn an_ego_on_the_profile_brakes_as_the_profile_falls() {
        let mut profile = SpeedProfile::constant(40.0);
        profile.cap(300.0, 310.0, 10.0, 2.0);
        profile.brake(2.0);
        let (at_m, mut speed_mps) = (100.0, 0.0);
        // The speed from which a braking that begins after the response is enough.
        for _ in 0..100 {
            speed_mps = profile.at_mps(at_m + RESPONSE_S * speed_mps);
        }
        let request_mps2 = profile.most_mps2(at_m, speed_mps);
        assert!((request_mps2 + 2.0).abs() < 1e-6, "{request_mps2}");
        assert!(profile.most_mps2(at_m, speed_mps - 2.0) > request_mps2 + 1.0);
    }

    #[test]
    fn the_lowest_speed_is_that_of_a_dip_between_the_ends() {
        let mut profile = SpeedProfile::constant(30.0);
        profile.cap(12.0, 13.0, 8.0, 1.0);
        assert_eq!(profile.lowest_mps(0.0, 20.0), 8.0);
        assert_eq!(profile.lowest_mps(20.0, 20.0), 30.0);
        assert!(profile.most_mps2(20.0, 0.0) > 0.0);
    }
}
