//! Settings of the two model-predictive laws, and of their formulation for the road.

use mpc_solver::{Clarabel, Riccati, Solver};
use parameters::parameters;
use scenario::Problem;
use scenario::controller::{Controller, Solver as SolverName, SpacingPolicy, Weights};

use law::following::driver::Driver;
use law::key;
use law::settings::{Number, Settings, Table, below, in_table, within};
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

pub(super) const TABLE: Table = Table::of::<RoadConfig>("road");

law::settings! {
    /// Settings of the road formulation; all decelerations are positive numbers.
    pub struct RoadConfig {
        /// Gap that is never given up knowingly, m; from 0.1 to `standstill_distance_m`.
        min_gap_m: f64 = 2.0, "m", 0.1..=50.0, "Chosen.";
        /// Distance of the stop ahead of the line, m.
        stop_margin_m: f64 = 1.0, "m", 0.3..=20.0, "Chosen.";
        /// Largest acceleration, m/s²; from 0.2 to `max_request_mps2`.
        acceleration_mps2: f64 = 2.0, "m/s²", 0.2..=12.0, "Chosen.";
        /// Largest deceleration that still counts as comfortable, m/s²; from 0.5 to -`min_request_mps2`.
        comfort_deceleration_mps2: f64 = 3.0, "m/s²", 0.5..=12.0, "Chosen.";
        /// Deceleration that the reference driver aims at, m/s²; from 0.2 to `comfort_deceleration_mps2`.
        reference_deceleration_mps2: f64 = 1.7, "m/s²", 0.2..=12.0, "Chosen.";
        /// Hardest deceleration of the lead that the safety filter allows for, m/s². The gap grows beyond the time headway
        /// where that needs more (above 28 m/s with the defaults).
        lead_deceleration_mps2: f64 = 7.0, "m/s²", 0.5..=12.0, "Chosen.";
        /// Time constant with which the lead's acceleration is predicted to decay, s.
        lead_decay_s: f64 = 1.5, "s", 0.05..=20.0, "Chosen.";
        /// Reaction time in a stop for yellow, s. The line may be crossed in yellow if a stop from the end of green would
        /// end beyond it. The stop has this time and the comfort deceleration. 0: only if a stop begun at once would.
        yellow_reaction_s: f64 = 1.0, "s", 0.0..=2.0, "Chosen.";
        /// Weight `w` of the light's penalty `w/D` at each stage before the end of green, m. `D` is how far the line is
        /// passed then.
        light_weight_m: f64 = 1500.0, "m", 0.0..=1e6, "Chosen.";
        /// Margin `D` beyond which the light costs nothing, m. The default is that of the paper's formulation.
        light_threshold_m: f64 = 108.5, "m", 0.1..=1e3, "Chosen.";
        /// Once decided, the other program must be better by this share of its cost to be taken.
        hysteresis: f64 = 0.2, "1", 0.0..=10.0, "Chosen.";
        /// Weight on the gap error's distance from the reference, 1/m².
        gap_weight_per_m2: f64 = 0.2, "1/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the speed's distance from the reference, s²/m².
        speed_weight_s2_per_m2: f64 = 1.0, "s²/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the acceleration, s⁴/m².
        acceleration_weight_s4_per_m2: f64 = 0.1, "s⁴/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the jerk, s⁶/m².
        jerk_weight_s6_per_m2: f64 = 0.5, "s⁶/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the request, s⁴/m².
        request_weight_s4_per_m2: f64 = 0.05, "s⁴/m²", 1e-6..=1e6, "Chosen.";
    }
}

impl Settings for RoadConfig {}

impl RoadConfig {
    /// Checks every setting, those included that depend on keys of `controller`. Keys are
    /// relative to `controller`.
    pub fn check_within(
        &self,
        (min_mps2, max_mps2): (f64, f64),
        standstill_m: f64,
    ) -> Result<(), Problem> {
        let comfort_mps2 = self.comfort_deceleration_mps2;
        within("road.min_gap_m", self.min_gap_m, 0.1, standstill_m)?;
        within("road.acceleration_mps2", self.acceleration_mps2, 0.2, max_mps2)?;
        within("road.comfort_deceleration_mps2", comfort_mps2, 0.5, -min_mps2)?;
        let reference_mps2 = self.reference_deceleration_mps2;
        within("road.reference_deceleration_mps2", reference_mps2, 0.2, comfort_mps2)?;
        self.check()
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
