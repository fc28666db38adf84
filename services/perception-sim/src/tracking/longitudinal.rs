//! The motion of a vehicle ahead along the road.
//!
//! State x = [d, w, a]: gap, relative speed (lead minus ego) and the lead's acceleration. The ego's
//! acceleration u is known. With Singer's model of the lead (acceleration of standard deviation sigma
//! and correlation time tau), r = e^(-T/tau):
//!
//! ```text
//! d+ = d + w T + (a - u) T²/2      w+ = w + (a - u) T      a+ = r a
//! P+ = F P F' + sigma² (1 - r²) b b',   b = [T²/2, T, 1]'
//! ```
//!
//! | symbol | key of `[perception.tracker]` | unit |
//! |---|---|---|
//! | sigma, tau | `lead_acceleration_sigma_mps2`, `maneuver_time_constant_s` | m/s², s |
//! | gate | `gate_sigma` | - |
//!
//! Such models run side by side ([`super::interacting`]): the one above for a quiet lead, and one for a hard manoeuvre.
//! One model alone either lags behind a lead that brakes hard, or shakes behind a quiet one.
//!
//! Sources: the radar filter of Li et al.'s predictive cruise control; Singer, Estimating optimal
//! tracking filter performance for manned maneuvering targets, IEEE Trans. Aerospace and Electronic
//! Systems 6 (1970) 473.

use super::interacting::Bank;
use super::numbers::Numbers;
use crate::radar::scene::Ego;
use kalman::Gaussian;
use scenario::Scenario;

/// Smallest standard deviation of a measurement, in its unit. Numeric guard: with less, rounding would decide.
pub const LEAST_SIGMA: f64 = 1e-3;
/// Models of the lead.
const MODELS: usize = 2;
/// Correlation time of a hard manoeuvre, s: a driver's braking.
const HARD_S: f64 = 1.5;
/// Mean time that a lead stays in each model, s: some time between two brakings, and the time of one.
const SOJOURNS_S: [f64; MODELS] = [5.0, 1.0];

/// A manoeuvring lead's acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maneuver {
    pub sigma_mps2: f64,
    pub tau_s: f64,
}

/// The parameters of all filters.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    maneuvers: [Maneuver; MODELS],
    gate: f64,
    numbers: Numbers,
}

/// A time step, over which the ego has a constant acceleration.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub dt_s: f64,
    pub ego: Ego,
}

/// Estimate of one vehicle's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub gap_m: f64,
    /// Lead speed minus ego speed, m/s.
    pub relative_speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Covariance in the order gap, relative speed, acceleration; symmetric.
    pub covariance: [[f64; 3]; 3],
}

/// A measured value with its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    pub value: f64,
    pub variance: f64,
}

impl Measured {
    /// A value with a standard deviation, which is taken as [`LEAST_SIGMA`] at least.
    pub fn new(value: f64, sigma: f64) -> Self {
        let sigma = sigma.max(LEAST_SIGMA);
        Self { value, variance: sigma * sigma }
    }
}

/// The filter of one vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter(Bank<3, MODELS>);

impl Model {
    pub fn of(scenario: &Scenario, numbers: &Numbers) -> Self {
        let keys = &scenario.perception.tracker;
        let quiet = Maneuver {
            sigma_mps2: keys.lead_acceleration_sigma_mps2.value(),
            tau_s: keys.maneuver_time_constant_s.value(),
        };
        Self::new(quiet, keys.gate_sigma.value(), numbers)
    }

    /// The model of a quiet lead and a gate in standard deviations.
    pub fn new(quiet: Maneuver, gate: f64, numbers: &Numbers) -> Self {
        let hard = Maneuver { sigma_mps2: numbers.hard_mps2, tau_s: HARD_S };
        Self { maneuvers: [quiet, hard], gate, numbers: *numbers }
    }

    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// A filter that starts with one measurement.
    pub fn start(&self, range: Measured, range_rate: Measured) -> Filter {
        let mean = [range.value, range_rate.value, 0.0];
        Filter(Bank::new(self.maneuvers.map(|maneuver| {
            let acceleration = maneuver.sigma_mps2 * maneuver.sigma_mps2;
            Gaussian::independent(mean, [range.variance, range_rate.variance, acceleration])
        })))
    }

    fn advance(&self, model: usize, step: &Step, state: &mut Gaussian<3>) {
        let Maneuver { sigma_mps2, tau_s } = self.maneuvers[model];
        let (dt_s, r) = (step.dt_s, libm::exp(-step.dt_s / tau_s));
        let half = 0.5 * dt_s * dt_s;
        let a = state.mean[2] - step.ego.acceleration_mps2;
        state.mean[0] += state.mean[1] * dt_s + a * half;
        state.mean[1] += a * dt_s;
        state.mean[2] *= r;
        let f = [[1.0, dt_s, half], [0.0, 1.0, dt_s], [0.0, 0.0, r]];
        state.spread(&f, &[half, dt_s, 1.0], sigma_mps2 * sigma_mps2 * (1.0 - r * r));
    }
}

impl Filter {
    pub fn predict(&mut self, model: &Model, step: &Step) {
        let change = SOJOURNS_S.map(|sojourn_s| (step.dt_s / sojourn_s).min(0.5));
        self.0.predict(&change, |index, state| model.advance(index, step, state));
    }

    /// Moves on a vehicle that is lost.
    ///
    /// The models lose an acceleration within seconds. Behind a lead that braked when it was lost, that would be a
    /// prediction on the unsafe side. So the last motion is carried on: it brakes on if it braked, and keeps its speed
    /// otherwise, until it stands.
    pub fn carry_on(&mut self, model: &Model, step: &Step) {
        let braking_mps2 = self.estimate().acceleration_mps2.min(0.0);
        let stands_mps = -step.ego.speed_mps;
        self.predict(model, step);
        self.0.change(|state| {
            let drives = state.mean[1] > stands_mps;
            state.mean[1] = state.mean[1].max(stands_mps);
            state.mean[2] = if drives { braking_mps2 } else { 0.0 };
        });
    }

    /// Takes in a measurement of range and range rate. One outside its gate is left out; true if both are within.
    ///
    /// No vehicle accelerates or brakes harder than its tyres allow. A greater jump of the speed was a wrong
    /// measurement, now or before.
    pub fn update(&mut self, model: &Model, range: Measured, range_rate: Measured) -> bool {
        let both = [(0, range.value, range.variance), (1, range_rate.value, range_rate.variance)];
        let [range_fits, rate_fits] = both.map(|(element, value, variance)| {
            self.0.widest(element, value, variance).passes(model.gate)
        });
        self.0.correct(&both[usize::from(!range_fits)..1 + usize::from(rate_fits)]);
        let hardest_mps2 = model.numbers.hardest_mps2;
        self.0.change(|state| state.mean[2] = state.mean[2].clamp(-hardest_mps2, hardest_mps2));
        range_fits && rate_fits
    }

    /// Variance with which a range rate is expected, without its own.
    pub fn range_rate_variance(&self) -> f64 {
        self.0.widest(1, 0.0, 0.0).variance
    }

    pub fn estimate(&self) -> Estimate {
        let Gaussian { mean, covariance } = *self.0.combined();
        let [gap_m, relative_speed_mps, acceleration_mps2] = mean;
        Estimate { gap_m, relative_speed_mps, acceleration_mps2, covariance }
    }
}

#[cfg(test)]
mod tests;
