//! The vehicle-following model: parameters, desired gap, and the two rules of the T-S model.

use law::settings::{Number, within};
use nalgebra::{SMatrix, SVector};
use parameters::parameters;
use scenario::Problem;
use serde::Deserialize;

/// States of the model, x = [Dd, Dv, a, u(k-1)].
pub const STATES: usize = 4;
/// Disturbances, w = [a_p, noise of Dd, noise of Dv, noise of a].
pub const DISTURBANCES: usize = 4;
/// Rules of the T-S model: at the least and at the greatest speed.
pub const RULES: usize = 2;

/// A model state, [m, m/s, m/s², m/s²].
pub type State = SVector<f64, STATES>;
/// A square matrix over the model states.
pub type StateMatrix = SMatrix<f64, STATES, STATES>;
/// Effect of the disturbances on the states or on the measurement.
pub type DisturbanceMatrix = SMatrix<f64, STATES, DISTURBANCES>;

parameters! {
    /// Conditions of a design. The default is the reference design, a reconstruction: the paper prints none of them.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct Parameters {
        /// Ts: period of the increments, s.
        sample_time_s: f64 = 0.1, "s", 1e-3..=1.0, "Chosen.";
        /// T: time constant of the acceleration, s.
        actuator_lag_s: f64 = 0.45, "s", 1e-2..=10.0, "Chosen.";
        /// c0 of the desired gap c0 + c1 v + c2 v², m.
        gap_constant_m: f64 = 5.0, "m", 0.0..=100.0, "Chosen.";
        /// c1, s.
        gap_slope_s: f64 = 1.5, "s", 0.0..=10.0, "Chosen.";
        /// c2, s²/m.
        gap_curvature_s2pm: f64 = 0.0285, "s²/m", 0.0..=1.0, "Chosen.";
        /// Speed of rule 1, m/s.
        least_speed_mps: f64 = 5.0, "m/s", 0.0..=100.0, "Chosen.";
        /// Speed of rule 2, m/s.
        greatest_speed_mps: f64 = 36.0, "m/s", 1.0..=150.0, "Chosen.";
        /// Bound on the lead's acceleration |a_p|, m/s².
        lead_acceleration_mps2: f64 = 1.5, "m/s²", 1e-3..=15.0, "Chosen.";
        /// Bound on the noise of the gap error, m.
        gap_noise_m: f64 = 0.25, "m", 1e-4..=100.0, "Chosen.";
        /// Bound on the noise of the speed error, m/s.
        speed_noise_mps: f64 = 0.1, "m/s", 1e-4..=50.0, "Chosen.";
        /// Bound on the noise of the acceleration, m/s².
        acceleration_noise_mps2: f64 = 0.05, "m/s²", 1e-4..=15.0, "Chosen.";
        /// Safety index: bound on |Dd|, m.
        gap_error_bound_m: f64 = 30.0, "m", 1e-2..=1e3, "Chosen.";
        /// Safety index: bound on |Dv|, m/s.
        speed_error_bound_mps: f64 = 12.0, "m/s", 1e-2..=150.0, "Chosen.";
        /// Comfort index: bound on |a|, m/s².
        acceleration_bound_mps2: f64 = 3.5, "m/s²", 1e-2..=15.0, "Chosen.";
        /// Comfort index: bound on |u|, m/s².
        request_bound_mps2: f64 = 3.5, "m/s²", 1e-2..=15.0, "Chosen.";
        /// Handiness index: bound on |Du| in one sample, m/s².
        increment_bound_mps2: f64 = 0.6, "m/s²", 1e-3..=15.0, "Chosen.";
        /// Efficiency index: bound on |Dd'|, m/s.
        gap_error_rate_bound_mps: f64 = 15.0, "m/s", 1e-2..=150.0, "Chosen.";
        others {
            /// States from which the guarantee must hold, [m, m/s, m/s², m/s²].
            /// By default behind leads that are 20 and 30 km/h slower.
            start_set: Vec<[f64; STATES]> = vec![[17.0, -5.56, 0.0, 0.0], [20.0, -8.34, 0.0, 0.0]];
        }
    }
}

impl Parameters {
    pub fn check(&self) -> Result<(), Problem> {
        Number::of("", self).iter().try_for_each(Number::check)?;
        within("greatest_speed_mps", self.greatest_speed_mps, self.least_speed_mps + 1e-3, 150.0)?;
        within("start_set (count)", self.start_set.len() as f64, 0.0, 16.0)?;
        self.start_set.iter().flatten().try_for_each(|v| within("start_set", *v, -1e3, 1e3))
    }

    /// d_des(v) = c0 + c1 v + c2 v², m.
    pub fn desired_gap_m(&self, speed: f64) -> f64 {
        self.gap_constant_m + (self.gap_slope_s + self.gap_curvature_s2pm * speed) * speed
    }

    /// rho(v) = c1 + 2 c2 v, the derivative of the desired gap, s.
    pub fn gap_derivative_s(&self, speed: f64) -> f64 {
        self.gap_slope_s + 2.0 * self.gap_curvature_s2pm * speed
    }

    /// h1, h2: how much each rule holds at a speed; not negative, sum 1.
    pub fn memberships(&self, speed: f64) -> [f64; RULES] {
        let h1 =
            (self.greatest_speed_mps - speed) / (self.greatest_speed_mps - self.least_speed_mps);
        let h1 = h1.clamp(0.0, 1.0);
        [h1, 1.0 - h1]
    }

    /// rho_i: the derivative of the desired gap at the speed of each rule, s.
    pub fn rule_derivatives_s(&self) -> [f64; RULES] {
        [self.least_speed_mps, self.greatest_speed_mps].map(|v| self.gap_derivative_s(v))
    }

    /// A_i of one rule.
    pub fn transition(&self, rho: f64) -> StateMatrix {
        let ts = self.sample_time_s;
        let share = ts / self.actuator_lag_s;
        let rows = [
            [1.0, ts, -ts * rho, 0.0],
            [0.0, 1.0, -ts, 0.0],
            [0.0, 0.0, 1.0 - share, share],
            [0.0, 0.0, 0.0, 1.0],
        ];
        StateMatrix::from_fn(|i, j| rows[i][j])
    }

    /// B: effect of the increment.
    pub fn input(&self) -> State {
        State::new(0.0, 0.0, self.sample_time_s / self.actuator_lag_s, 1.0)
    }

    /// E: effect of the disturbances on the state; only the lead's acceleration has one.
    pub fn disturbance(&self) -> DisturbanceMatrix {
        let mut e = DisturbanceMatrix::zeros();
        e[(1, 0)] = self.sample_time_s;
        e
    }

    /// D: effect of the disturbances on the measurement y = x + D w.
    pub fn measurement_noise(&self) -> DisturbanceMatrix {
        let mut d = DisturbanceMatrix::zeros();
        for i in 0..DISTURBANCES - 1 {
            d[(i, i + 1)] = 1.0;
        }
        d
    }

    /// Bounds on the disturbances, in the order of w.
    pub fn disturbance_bounds(&self) -> [f64; DISTURBANCES] {
        [
            self.lead_acceleration_mps2,
            self.gap_noise_m,
            self.speed_noise_mps,
            self.acceleration_noise_mps2,
        ]
    }

    /// Bounds on the states, in the order of x.
    pub fn state_bounds(&self) -> [f64; STATES] {
        [
            self.gap_error_bound_m,
            self.speed_error_bound_mps,
            self.acceleration_bound_mps2,
            self.request_bound_mps2,
        ]
    }

    /// The row of the efficiency index Dd' under a rule.
    pub fn gap_error_rate_row(&self, rho: f64) -> State {
        State::new(0.0, 1.0, -rho, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// rho is affine in v, so the two rules blend to the true derivative: the model is exact.
    #[test]
    fn the_two_rules_blend_to_the_true_model() {
        let p = Parameters::default();
        for v in [5.0, 12.3, 20.0, 36.0] {
            let blended: f64 =
                p.memberships(v).iter().zip(p.rule_derivatives_s()).map(|(h, r)| h * r).sum();
            assert!((blended - p.gap_derivative_s(v)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_desired_gap_at_110_kmh() {
        assert!((Parameters::default().desired_gap_m(110.0 / 3.6) - 77.4).abs() < 0.1);
    }

    #[test]
    fn a_bad_value_names_its_key() {
        let base = Parameters::default;
        assert_eq!(base().check(), Ok(()));
        let key = |p: Parameters| p.check().expect_err("must be refused").path;
        assert_eq!(key(Parameters { actuator_lag_s: 0.0, ..base() }), "actuator_lag_s");
        assert_eq!(key(Parameters { gap_noise_m: f64::NAN, ..base() }), "gap_noise_m");
        assert_eq!(key(Parameters { least_speed_mps: 36.0, ..base() }), "greatest_speed_mps");
        let start_set = vec![[f64::INFINITY; 4]];
        assert_eq!(key(Parameters { start_set, ..base() }), "start_set");
    }
}
