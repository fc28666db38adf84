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
//! With `filter = "singer"` that is all. A range rate outside the gate opens the filter. It assumes a hard manoeuvre of
//! the lead ([`Numbers::hard_mps2`]), and judges the measurement again. With `filter = "interacting-models"` three such
//! models run side by side ([`super::interacting`]): the one above, moderate and hard manoeuvres.
//!
//! Sources: the radar filter of Li et al.'s predictive cruise control; Singer, Estimating optimal
//! tracking filter performance for manned maneuvering targets, IEEE Trans. Aerospace and Electronic
//! Systems 6 (1970) 473.

use super::interacting::Bank;
use super::numbers::Numbers;
use kalman::Gaussian;
use scenario::Scenario;
use scenario::perception::TrackingFilter;

/// Smallest standard deviation of a measurement, in its unit. Numeric guard: with less, rounding would decide.
pub const LEAST_SIGMA: f64 = 1e-3;

/// A manoeuvring lead's acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maneuver {
    /// Standard deviation, m/s².
    pub sigma_mps2: f64,
    /// Correlation time, s.
    pub tau_s: f64,
}

/// Filter behind a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One model of the lead.
    Singer,
    /// Three models of the lead side by side.
    Interacting,
}

/// The parameters of all filters.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    kind: Kind,
    maneuvers: [Maneuver; 3],
    gate: f64,
    numbers: Numbers,
}

/// A time step, with what depends on its length alone.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    dt_s: f64,
    kept: [f64; 3],
    change: [f64; 3],
    ego_acceleration_mps2: f64,
}

impl Step {
    /// Length, s.
    #[must_use]
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }
}

/// Estimate of one vehicle's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Gap, m.
    pub gap_m: f64,
    /// Lead speed minus ego speed, m/s.
    pub relative_speed_mps: f64,
    /// Acceleration of the lead, m/s².
    pub acceleration_mps2: f64,
    /// Covariance in the order gap, relative speed, acceleration; symmetric.
    pub covariance: [[f64; 3]; 3],
}

impl Estimate {
    /// Constant braking that keeps the ego behind a vehicle of constant speed, m/s². It is 0 if they do not come
    /// closer.
    #[must_use]
    pub fn braking_mps2(&self) -> f64 {
        let closing_mps = (-self.relative_speed_mps).max(0.0);
        closing_mps * closing_mps / (2.0 * self.gap_m.max(1.0))
    }
}

/// A measured value with its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Value.
    pub value: f64,
    /// Variance.
    pub variance: f64,
}

impl Measured {
    /// A value with a standard deviation, which is taken as [`LEAST_SIGMA`] at least.
    #[must_use]
    pub fn new(value: f64, sigma: f64) -> Self {
        let sigma = sigma.max(LEAST_SIGMA);
        Self { value, variance: sigma * sigma }
    }
}

/// Measurements that passed their gates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassedGates {
    /// The range passed its gate.
    pub range: bool,
    /// The range rate passed its gate.
    pub range_rate: bool,
}

/// The filter of one vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    bank: Models,
    combined: Gaussian<3>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Models {
    Singer(Bank<3, 1>),
    Interacting(Bank<3, 3>),
}

impl Model {
    /// The model of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario, numbers: &Numbers) -> Self {
        let keys = &scenario.perception.tracker;
        let quiet = Maneuver {
            sigma_mps2: keys.lead_acceleration_sigma_mps2.value(),
            tau_s: keys.maneuver_time_constant_s.value(),
        };
        let kind = match keys.filter {
            TrackingFilter::Singer => Kind::Singer,
            TrackingFilter::InteractingModels => Kind::Interacting,
        };
        Self::new(kind, quiet, keys.gate_sigma.value(), numbers)
    }

    /// The model of a quiet lead and a gate in standard deviations.
    #[must_use]
    pub fn new(kind: Kind, quiet: Maneuver, gate: f64, numbers: &Numbers) -> Self {
        let moderate = Maneuver { sigma_mps2: numbers.moderate_mps2, tau_s: numbers.moderate_s };
        let hard = Maneuver { sigma_mps2: numbers.hard_mps2, tau_s: numbers.hard_s };
        Self { kind, maneuvers: [quiet, moderate, hard], gate, numbers: *numbers }
    }

    /// The tracker's numbers.
    #[must_use]
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// A step of `dt_s` over which the ego has a constant acceleration.
    #[must_use]
    pub fn step(&self, dt_s: f64, ego_acceleration_mps2: f64) -> Step {
        let Numbers { quiet_sojourn_s, moderate_sojourn_s, hard_sojourn_s, .. } = self.numbers;
        let sojourns_s = [quiet_sojourn_s, moderate_sojourn_s, hard_sojourn_s];
        Step {
            dt_s,
            kept: self.maneuvers.map(|maneuver| libm::exp(-dt_s / maneuver.tau_s)),
            change: sojourns_s.map(|sojourn_s| (dt_s / sojourn_s).min(0.5)),
            ego_acceleration_mps2,
        }
    }

    /// A filter that starts with one measurement.
    #[must_use]
    pub fn start(&self, range: Measured, range_rate: Measured) -> Filter {
        let mean = [range.value, range_rate.value, 0.0];
        let known = |maneuver: &Maneuver| {
            let acceleration = maneuver.sigma_mps2 * maneuver.sigma_mps2;
            Gaussian::independent(mean, [range.variance, range_rate.variance, acceleration])
        };
        let bank = match self.kind {
            Kind::Singer => Models::Singer(Bank::new([known(&self.maneuvers[0])])),
            Kind::Interacting => {
                Models::Interacting(Bank::new(self.maneuvers.each_ref().map(known)))
            }
        };
        Filter { bank, combined: known(&self.maneuvers[0]) }
    }

    fn advance(&self, model: usize, step: &Step, state: &mut Gaussian<3>) {
        let (dt_s, r) = (step.dt_s, step.kept[model]);
        let half = 0.5 * dt_s * dt_s;
        let a = state.mean[2] - step.ego_acceleration_mps2;
        state.mean[0] += state.mean[1] * dt_s + a * half;
        state.mean[1] += a * dt_s;
        state.mean[2] *= r;
        let f = [[1.0, dt_s, half], [0.0, 1.0, dt_s], [0.0, 0.0, r]];
        let sigma = self.maneuvers[model].sigma_mps2;
        state.spread(&f, &[half, dt_s, 1.0], sigma * sigma * (1.0 - r * r));
    }
}

impl Filter {
    /// Moves the estimate on.
    pub fn predict(&mut self, model: &Model, step: &Step) {
        match &mut self.bank {
            Models::Singer(bank) => {
                bank.predict(&[0.0], |index, state| model.advance(index, step, state));
            }
            Models::Interacting(bank) => {
                bank.predict(&step.change, |index, state| model.advance(index, step, state));
            }
        }
        self.combine();
    }

    /// Takes in a measurement of range and range rate; one outside its gate is left out.
    pub fn update(
        &mut self,
        model: &Model,
        step: &Step,
        range: Measured,
        range_rate: Measured,
    ) -> PassedGates {
        let mut believed = PassedGates {
            range: self.passes(model, 0, range),
            range_rate: self.passes(model, 1, range_rate),
        };
        if !believed.range_rate {
            self.open(model, step.dt_s);
            believed.range_rate = self.passes(model, 1, range_rate);
        }
        let both = [(0, range.value, range.variance), (1, range_rate.value, range_rate.variance)];
        let taken = match (believed.range, believed.range_rate) {
            (true, true) => &both[..],
            (true, false) => &both[..1],
            (false, true) => &both[1..],
            (false, false) => &[],
        };
        match &mut self.bank {
            Models::Singer(bank) => bank.correct(taken),
            Models::Interacting(bank) => bank.correct(taken),
        }
        self.bound(model.numbers.hardest_mps2);
        self.combine();
        believed
    }

    /// Takes in a range rate alone.
    pub fn see_range_rate(&mut self, model: &Model, step: &Step, range_rate: Measured) {
        let unknown = Measured { value: f64::NAN, variance: 1.0 };
        self.update(model, step, unknown, range_rate);
    }

    fn passes(&self, model: &Model, element: usize, measured: Measured) -> bool {
        let Measured { value, variance } = measured;
        match &self.bank {
            Models::Singer(bank) => bank.widest(element, value, variance).passes(model.gate),
            Models::Interacting(bank) => bank.widest(element, value, variance).passes(model.gate),
        }
    }

    /// No vehicle accelerates or brakes harder than this. A greater jump of the speed was a wrong measurement, now or
    /// before.
    fn bound(&mut self, hardest_mps2: f64) {
        let bound = |state: &mut Gaussian<3>| {
            state.mean[2] = state.mean[2].clamp(-hardest_mps2, hardest_mps2);
        };
        match &mut self.bank {
            Models::Singer(bank) => bank.for_each(bound),
            Models::Interacting(bank) => bank.for_each(bound),
        }
    }

    /// A filter of one model assumes a hard manoeuvre since the last step.
    fn open(&mut self, model: &Model, dt_s: f64) {
        if let Models::Singer(bank) = &mut self.bank {
            let hard = model.numbers.hard_mps2 * model.numbers.hard_mps2;
            bank.for_each(|state| {
                let missing = (hard - state.covariance[2][2]).max(0.0);
                let b = [0.0, dt_s, 1.0];
                for i in 0..3 {
                    for j in 0..3 {
                        state.covariance[i][j] += missing * b[i] * b[j];
                    }
                }
            });
        }
    }

    /// Variance with which a range rate of the given variance is expected, `since_s` after the last one. One model has
    /// to expect the hard manoeuvre with which [`Self::update`] would judge the measurement again. An unexpected one
    /// never comes to it.
    #[must_use]
    pub fn range_rate_variance(&self, model: &Model, variance: f64, since_s: f64) -> f64 {
        match &self.bank {
            Models::Singer(bank) => {
                let hard_mps = model.numbers.hard_mps2 * since_s;
                bank.widest(1, 0.0, variance).variance + hard_mps * hard_mps
            }
            Models::Interacting(bank) => bank.widest(1, 0.0, variance).variance,
        }
    }

    /// The estimate.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let [gap_m, relative_speed_mps, acceleration_mps2] = self.combined.mean;
        let covariance = self.combined.covariance;
        Estimate { gap_m, relative_speed_mps, acceleration_mps2, covariance }
    }

    fn combine(&mut self) {
        self.combined = match &self.bank {
            Models::Singer(bank) => bank.combined(),
            Models::Interacting(bank) => bank.combined(),
        };
    }
}

#[cfg(test)]
mod tests;
