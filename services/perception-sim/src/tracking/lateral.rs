//! The motion of a vehicle across the lanes.
//!
//! State [y, s]: lateral position, m, and lateral speed, m/s. Two models run side by side ([`super::interacting`]). One
//! is for a vehicle that keeps its lane; its lateral speed fades with [`Numbers::fading_s`]. The other is for a lane
//! change, with a random walk of the lateral speed. The noise is a white acceleration of the given density.

use super::interacting::Bank;
use super::longitudinal::Measured;
use super::numbers::Numbers;
use kalman::Gaussian;

/// The filter of one vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter(Bank<2, 2>);

impl Filter {
    /// A filter that starts with one measured position, m.
    pub fn start(position: Measured, numbers: &Numbers) -> Self {
        let speed_variance = numbers.first_lateral_mps * numbers.first_lateral_mps;
        let state =
            Gaussian::independent([position.value, 0.0], [position.variance, speed_variance]);
        Self(Bank::new([state; 2]))
    }

    pub fn predict(&mut self, dt_s: f64, numbers: &Numbers) {
        let density = [numbers.in_lane_m2ps3, numbers.lane_change_m2ps3];
        let sojourns_s = [numbers.in_lane_s, numbers.lane_change_s];
        let change = sojourns_s.map(|sojourn_s| (dt_s / sojourn_s).min(0.5));
        // The first order of the fading's exponential: steps are short beside it.
        let fading = [1.0 / (1.0 + dt_s / numbers.fading_s), 1.0];
        self.0.predict(&change, |model, state| {
            let kept = fading[model];
            state.mean[0] += dt_s * state.mean[1];
            state.mean[1] *= kept;
            state.spread(&[[1.0, dt_s], [0.0, kept]], &[0.5 * dt_s, 1.0], density[model] * dt_s);
        });
    }

    /// Takes in a measured position, m. A distant one counts as one at the limit.
    pub fn update(&mut self, position: Measured, numbers: &Numbers) {
        let innovation = self.0.widest(0, position.value, position.variance);
        let limit = numbers.surely_sigma * innovation.variance.sqrt();
        let predicted = position.value - innovation.residual;
        let value = predicted + innovation.residual.clamp(-limit, limit);
        if value.is_finite() {
            self.0.correct(&[(0, value, position.variance)]);
        }
    }

    /// Moves the position by `by_m`: the axis from which it is measured has moved the other way.
    pub fn shift(&mut self, by_m: f64) {
        self.0.change(|state| state.mean[0] += by_m);
    }

    pub fn position_m(&self) -> f64 {
        self.0.combined().mean[0]
    }

    pub fn position(&self) -> Measured {
        let variance = self.0.combined().covariance[0][0].max(0.0);
        Measured { value: self.position_m(), variance }
    }

    pub fn speed_mps(&self) -> f64 {
        self.0.combined().mean[1]
    }

    pub fn position_sigma_m(&self) -> f64 {
        self.0.combined().covariance[0][0].max(0.0).sqrt()
    }

    pub fn speed_sigma_mps(&self) -> f64 {
        self.0.combined().covariance[1][1].max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.05;

    /// Repeatable errors with a standard deviation of about 1.
    fn error(k: u32) -> f64 {
        let mixed = u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        (mixed as f64 / f64::from(1 << 24) - 0.5) * 12f64.sqrt()
    }

    /// Runs the filter over a lateral motion measured with `sigma_m`; calls back after each scan.
    fn follow(sigma_m: f64, motion: impl Fn(f64) -> f64, mut see: impl FnMut(f64, &Filter)) {
        let measured = |k: u32| motion(f64::from(k) * DT_S) + sigma_m * error(k);
        let mut filter = Filter::start(Measured::new(measured(0), sigma_m), &Numbers::DEFAULT);
        for k in 1..400 {
            filter.predict(DT_S, &Numbers::DEFAULT);
            filter.update(Measured::new(measured(k), sigma_m), &Numbers::DEFAULT);
            see(f64::from(k) * DT_S, &filter);
        }
    }

    #[test]
    fn a_vehicle_in_lane_has_little_lateral_speed() {
        let mut worst = 0.0f64;
        follow(
            0.25,
            |_| 3.5,
            |time_s, filter| {
                if time_s > 2.0 {
                    worst = worst.max(filter.speed_mps().abs());
                }
            },
        );
        assert!(worst < 0.35, "{worst} m/s");
    }

    #[test]
    fn a_lane_change_is_seen_within_a_third_of_a_second() {
        let mut seen_s = f64::INFINITY;
        follow(
            0.15,
            |time_s| 3.5 - 1.2 * (time_s - 5.0).max(0.0),
            |time_s, filter| {
                if time_s > 5.0 && filter.speed_mps() < -0.6 {
                    seen_s = seen_s.min(time_s - 5.0);
                }
            },
        );
        assert!(seen_s < 0.36, "{seen_s} s");
    }

    #[test]
    fn a_shift_moves_the_position_and_nothing_else() {
        let mut filter = Filter::start(Measured::new(1.0, 0.2), &Numbers::DEFAULT);
        filter.predict(DT_S, &Numbers::DEFAULT);
        filter.update(Measured::new(1.3, 0.2), &Numbers::DEFAULT);
        let mut shifted = filter;
        shifted.shift(0.5);
        assert!((shifted.position_m() - filter.position_m() - 0.5).abs() < 1e-12);
        assert_eq!(shifted.speed_mps(), filter.speed_mps());
        // The rest is the same, shifted.
        filter.update(Measured::new(1.2, 0.2), &Numbers::DEFAULT);
        shifted.update(Measured::new(1.7, 0.2), &Numbers::DEFAULT);
        assert!((shifted.position_m() - filter.position_m() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn one_wild_position_moves_it_little() {
        let mut filter = Filter::start(Measured::new(0.0, 0.2), &Numbers::DEFAULT);
        for _ in 0..100 {
            filter.predict(DT_S, &Numbers::DEFAULT);
            filter.update(Measured::new(0.0, 0.2), &Numbers::DEFAULT);
        }
        filter.update(Measured::new(50.0, 0.2), &Numbers::DEFAULT);
        assert!(filter.position_m() < 0.6, "{}", filter.position_m());
        let before = filter;
        filter.update(Measured::new(f64::NAN, 0.2), &Numbers::DEFAULT);
        assert_eq!(filter, before);
    }

    #[track_caller]
    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }

    /// Both models begin alike. In 0.05 s the vehicle begins a lane change with 0.01, and ends one with 0.025.
    #[test]
    fn a_step_spreads_the_position_by_speed_and_noise() {
        let mut filter = Filter::start(Measured::new(1.0, 0.2), &Numbers::DEFAULT);
        filter.predict(DT_S, &Numbers::DEFAULT);
        let in_lane = 0.95 * 0.99 + 0.05 * 0.025;
        let kept = 1.0 / 1.05;
        // The noise is an acceleration along [0.025 s, 1].
        let noise = [0.01 * 0.05, 2.0 * 0.05];
        let position = |noise: f64| 0.04 + 0.05 * 0.05 + noise * 0.025 * 0.025;
        let mean = |of: [f64; 2]| in_lane * of[0] + (1.0 - in_lane) * of[1];
        let expected_m2 = mean(noise.map(position));
        assert_near(filter.position().variance, expected_m2);
        assert_near(filter.position_sigma_m(), expected_m2.sqrt());
        let expected_m2ps2 = mean([kept * kept + noise[0], 1.0 + noise[1]]);
        assert_near(filter.speed_sigma_mps(), expected_m2ps2.sqrt());
        assert_eq!(
            (filter.position().value, filter.position_m(), filter.speed_mps()),
            (1.0, 1.0, 0.0)
        );
    }

    #[test]
    fn a_speed_moves_the_position_and_fades_in_the_lane() {
        let mut filter = Filter::start(Measured::new(1.0, 0.2), &Numbers::DEFAULT);
        filter.0.change(|state| state.mean[1] = 2.0);
        filter.predict(DT_S, &Numbers::DEFAULT);
        assert_near(filter.position_m(), 1.1);
        let in_lane = 0.95 * 0.99 + 0.05 * 0.025;
        assert_near(filter.speed_mps(), 2.0 * (in_lane / 1.05 + (1.0 - in_lane)));
    }

    #[test]
    fn a_position_counts_up_to_three_deviations() {
        let after = |position_m: f64| {
            let mut filter = Filter::start(Measured::new(1.0, 0.2), &Numbers::DEFAULT);
            filter.update(Measured::new(position_m, 0.2), &Numbers::DEFAULT);
            filter.position_m()
        };
        // Both are equally sure of it.
        assert_near(after(1.4), 1.2);
        let limit_m = 3.0 * f64::sqrt(0.08);
        assert_near(after(9.0), 1.0 + 0.5 * limit_m);
        assert_near(after(-9.0), 1.0 - 0.5 * limit_m);
    }
}
