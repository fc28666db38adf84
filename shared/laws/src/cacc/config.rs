//! Settings of the two model-predictive laws.

use mpc_solver::{Clarabel, Riccati, Solver};
use parameters::parameters;
use scenario::Problem;
use scenario::controller::{Controller, Solver as SolverName, SpacingPolicy, Weights};

use super::road_config::{RoadConfig, TABLE};
use law::following::driver::Driver;
use law::key;
use law::settings::{Number, below, in_table, within};
use law::{MAX_PLAN, Reader};

/// Handling of signals by a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signals {
    /// `acc-mpc`.
    Ignored,
    /// `cacc-mpc`.
    Used,
}

parameters! {
    /// Settings of `acc-mpc` and `cacc-mpc`. The numbers have the names and the defaults of the scenario's keys.
    #[derive(Copy)]
    pub struct Config {
        /// Steps of the prediction, `N`.
        horizon: usize = 100, "1", 10.0..=128.0, "The scenario's key.";
        /// Lag of the vehicle's acceleration behind the request, `tau`, s.
        model_time_constant_s: f64 = 0.5, "s", 0.05..=5.0, "The scenario's key.";
        /// Smallest request, m/s².
        min_request_mps2: f64 = -4.9, "m/s²", -12.0..=-0.5, "The scenario's key.";
        /// Largest request, m/s².
        max_request_mps2: f64 = 4.9, "m/s²", 0.5..=12.0, "The scenario's key.";
        /// Time headway `t_h`, s.
        time_headway_s: f64 = 1.5, "s", 0.3..=5.0, "The scenario's key.";
        /// Gap at standstill, m: the paper's buffer `d_b`.
        standstill_distance_m: f64 = 5.0, "m", 1.0..=50.0, "The scenario's key.";
        others {
            /// Step of the prediction, `T`, s.
            step_s: f64 = 0.1;
            /// Form of the desired distance, and with it the formulation.
            spacing_policy: SpacingPolicy = SpacingPolicy::ConstantTimeHeadway;
            /// Solver of the convex programs.
            solver: SolverName = SolverName::Riccati;
            /// Weights of the paper's cost.
            weights: Weights = Weights::default();
            /// Settings of the formulation for the road.
            road: RoadConfig = RoadConfig::default();
        }
    }
}

/// The scenario's key of the step.
const STEP: &str = "prediction_step_ms";

const _: () = assert!(MAX_PLAN == 128, "the longest horizon fits a plan");

impl Config {
    /// The settings of a scenario, in the formulation that its spacing policy chooses.
    pub fn of(reader: &Reader<'_>, signals: Signals) -> Result<Self, Problem> {
        match key!(reader, spacing_policy) {
            SpacingPolicy::ConstantTimeHeadway => {
                if signals == Signals::Ignored {
                    let of_signals = [
                        "stop_margin_m",
                        "yellow_reaction_s",
                        "light_weight_m",
                        "light_threshold_m",
                        "hysteresis",
                    ];
                    reader.without(TABLE.name, &of_signals);
                }
                Self::of_road(reader)
            }
            spacing_policy => {
                let mut weights = Weights {
                    q1: key!(reader, weights.q1),
                    q2: key!(reader, weights.q2),
                    q3: key!(reader, weights.q3),
                    r: key!(reader, weights.r),
                    ..Weights::default()
                };
                if signals == Signals::Used {
                    weights.light_stages = key!(reader, weights.light_stages);
                    weights.light_weight = key!(reader, weights.light_weight);
                    weights.light_threshold_m = key!(reader, weights.light_threshold_m);
                }
                // The driver that takes over in the end.
                let keys = ["acceleration_mps2", "reference_deceleration_mps2"];
                let road = reader.part_of_table(TABLE.name, &keys)?;
                Ok(Self { spacing_policy, weights, road, ..Self::shared(reader) })
            }
        }
    }

    pub fn of_road(reader: &Reader<'_>) -> Result<Self, Problem> {
        let road = reader.table(TABLE.name)?;
        Ok(Self { road, ..Self::shared(reader) })
    }

    /// The settings that all formulations have.
    fn shared(reader: &Reader<'_>) -> Self {
        let step = reader.key(STEP, Controller::prediction_step);
        Self {
            solver: key!(reader, solver),
            horizon: key!(reader, horizon).value().into(),
            step_s: f64::from(step.value()) / 1e3,
            model_time_constant_s: key!(reader, model_time_constant_s).value(),
            min_request_mps2: key!(reader, min_request_mps2).value(),
            max_request_mps2: key!(reader, max_request_mps2).value(),
            time_headway_s: key!(reader, time_headway_s).value(),
            standstill_distance_m: key!(reader, standstill_distance_m).value(),
            ..Self::default()
        }
    }

    /// The driver that makes references, and drives where a program has no solution.
    pub(super) fn driver(&self) -> Driver {
        Driver {
            acceleration_mps2: self.road.acceleration_mps2,
            deceleration_mps2: self.road.reference_deceleration_mps2,
            hardest_mps2: -self.min_request_mps2,
        }
    }

    pub fn create_solver(&self) -> Box<dyn Solver + Send> {
        match self.solver {
            SolverName::Riccati => Box::new(Riccati::new(self.horizon)),
            SolverName::Clarabel => Box::new(Clarabel::new()),
        }
    }

    /// Checks every setting; keys are relative to `controller`.
    pub fn check(&self) -> Result<(), Problem> {
        Number::of("", self).iter().try_for_each(Number::check)?;
        // The key's unit. A thousandth has no exact form: what was typed is shown.
        let in_ms = |seconds: f64| (seconds * 1e9).round() / 1e6;
        within(STEP, in_ms(self.step_s), 10.0, 500.0)?;
        let lag_ms = in_ms(self.model_time_constant_s);
        below(STEP, in_ms(self.step_s), "model_time_constant_s", lag_ms)?;
        let bounds_mps2 = (self.min_request_mps2, self.max_request_mps2);
        self.road.check_within(bounds_mps2, self.standstill_distance_m)
    }

    /// A problem at its place in the scenario.
    pub(super) fn in_scenario(problem: Problem, controller: &Controller) -> Problem {
        let is_of_step = problem.path == STEP;
        if is_of_step && controller.prediction_step_ms.is_none() {
            // Without a step of its own the prediction has the controller's.
            let message = problem.message.replace(STEP, "period_ms");
            return Problem::new("controller.period_ms", message, problem.expected);
        }
        in_table(problem, "controller")
    }
}

#[cfg(test)]
mod tests {
    use scenario::Scenario;
    use scenario::quantity::PeriodMs;

    use super::*;

    #[test]
    fn the_default_is_valid() {
        assert_eq!(Config::default().check(), Ok(()));
    }

    #[test]
    fn errors_are_in_the_words_and_units_of_the_scenario() {
        let said = |config: Config| {
            let error = config.check().expect_err("out of range");
            let Problem { message, expected, .. } =
                Config::in_scenario(error, &Controller::default());
            format!("{message}, expected {expected}")
        };
        let set =
            Controller { prediction_step_ms: Some(PeriodMs::of(1000)), ..Controller::default() };
        let slow = Config { step_s: 1.0, ..Config::default() }.check().expect_err("out of range");
        assert_eq!(
            Config::in_scenario(slow, &set).to_string(),
            "controller.prediction_step_ms: prediction_step_ms = 1000 is out of range, expected a number from 10 to 500"
        );
        for period_ms in [1, 100, 500, 501, 1000, 10_000] {
            let period_ms = PeriodMs::of(period_ms);
            let text = "schema_version = 1\nname = \"a\"\n";
            let mut scenario = Scenario::parse("a", text).expect("a scenario");
            scenario.controller.period_ms = period_ms;
            let config = Config::of_road(&Reader::new(&scenario)).expect("the defaults");
            assert!(config.step_s <= 0.5, "{period_ms:?}: {}", config.step_s);
        }
        let long = said(Config { horizon: 1000, ..Config::default() });
        assert_eq!(long, "horizon = 1000 is out of range, expected a number from 10 to 128");
        let beyond = said(Config { step_s: 0.4, model_time_constant_s: 0.3, ..Config::default() });
        let expected =
            "period_ms = 400 is too large, expected a number below model_time_constant_s (300)";
        assert_eq!(beyond, expected);
        let small = said(Config { model_time_constant_s: 1e-9, ..Config::default() });
        assert!(small.starts_with("model_time_constant_s = 0.000000001 is"), "{small}");
    }

    #[test]
    fn a_value_that_is_not_a_number_or_contradicts_is_refused() {
        let nan = Config { model_time_constant_s: f64::NAN, ..Config::default() };
        assert_eq!(nan.check().expect_err("NaN").path, "model_time_constant_s");
        let slow = Config { step_s: 0.4, model_time_constant_s: 0.3, ..Config::default() };
        assert_eq!(slow.check().expect_err("a step beyond the lag").path, STEP);
    }
}
