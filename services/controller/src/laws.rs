//! Which law a scenario asks for, and with what parameters.

use crate::cacc::config::{Config, ConfigError, SolverKind, SpacingPolicy};
use crate::cacc::road::RoadConfig;
use crate::cacc::weights::{WeightSet, Weights};
use crate::cacc::{self, BuildError};
use crate::law::Law;
use crate::predictive::{PlannerKind, Predictive, Settings};
use crate::quadratic_bounded::{Design, QuadraticBounded};
use crate::six_mode::SixMode;
use scenario::controller::{self, Controller, ControllerName, SpacingPolicy as ScenarioPolicy};
use scenario::{Problem, Scenario};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use truck_model::{Preset, Truck};

/// What a law is, in one line.
#[must_use]
pub fn describe(name: ControllerName) -> &'static str {
    match name {
        ControllerName::AccMpc => {
            "predictive following, blind to signals (He et al. 2024, baseline)"
        }
        ControllerName::CaccMpc => {
            "predictive following through signalised intersections (He et al. 2024)"
        }
        ControllerName::SixMode => "six switched modes (Wang et al. 2014)",
        ControllerName::QuadraticBounded => {
            "output feedback that keeps all indices within bounds (Gao et al. 2015)"
        }
        ControllerName::Predictive => {
            "predictive cruise of a heavy truck over hills (Li, Zheng, Wang, Wang)"
        }
    }
}

/// Builds the law of a scenario.
///
/// # Errors
/// Names the key that the law refuses.
pub fn build(scenario: &Scenario) -> Result<Box<dyn Law>, Problem> {
    let controller = &scenario.controller;
    match controller.name {
        ControllerName::AccMpc => predictive(cacc::Controller::AccMpc, controller),
        ControllerName::CaccMpc => predictive(cacc::Controller::CaccMpc, controller),
        ControllerName::SixMode => six_mode(controller),
        ControllerName::QuadraticBounded => quadratic_bounded(controller),
        ControllerName::Predictive => truck(scenario),
    }
}

/// Checks that the scenario's law accepts its parameters.
///
/// # Errors
/// Names the key that the law refuses.
pub fn check(scenario: &Scenario) -> Result<(), Problem> {
    build(scenario).map(|_| ())
}

/// Names of the figures that the scenario's law puts into `control/diagnostics`.
#[must_use]
pub fn figure_names(scenario: &Scenario) -> &'static [&'static str] {
    build(scenario).map_or(&[], |law| law.figure_names())
}

/// Names of the modes of the scenario's law.
#[must_use]
pub fn mode_names(scenario: &Scenario) -> &'static [&'static str] {
    build(scenario).map_or(&[], |law| law.mode_names())
}

fn predictive(which: cacc::Controller, controller: &Controller) -> Result<Box<dyn Law>, Problem> {
    let config = predictive_config(controller)?;
    match cacc::build(which, &config) {
        Ok(law) => Ok(law),
        Err(BuildError::Config(error)) => Err(config_problem(&error, controller)),
        Err(BuildError::Problem(error)) => {
            Err(Problem::new("controller", error.to_string(), "weights of a convex problem"))
        }
    }
}

fn six_mode(controller: &Controller) -> Result<Box<dyn Law>, Problem> {
    let table = "controller.six_mode";
    let parameters = read_table(&controller.six_mode, table)?;
    match SixMode::new(parameters) {
        Ok(law) => Ok(Box::new(law)),
        Err(error) => Err(Problem::new(
            format!("{table}.{}", error.key),
            error.to_string(),
            "a parameter in its range",
        )),
    }
}

fn quadratic_bounded(controller: &Controller) -> Result<Box<dyn Law>, Problem> {
    let table = "controller.quadratic_bounded";
    let mut settings = controller.quadratic_bounded.clone();
    let design = match settings.remove("design") {
        None => Design::shipped(),
        Some(path) => load_design(&path)
            .map_err(|why| Problem::new(format!("{table}.design"), why, "a certified design"))?,
    };
    let settings = read_table(&settings, table)?;
    match QuadraticBounded::new(design, settings) {
        Ok(law) => Ok(Box::new(law)),
        Err(error) => Err(Problem::new(table, error, "a setting in its range")),
    }
}

/// `[controller.predictive]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PredictiveKeys {
    planner: String,
    mean_speed: f64,
}

impl Default for PredictiveKeys {
    fn default() -> Self {
        Self { planner: PlannerKind::default().name().to_owned(), mean_speed: 1.0 }
    }
}

/// The truck as the law believes it to be; on a car it drives as the heavier one would.
fn truck(scenario: &Scenario) -> Result<Box<dyn Law>, Problem> {
    let table = "controller.predictive";
    let keys: PredictiveKeys = read_table(&scenario.controller.predictive, table)?;
    let planner = PlannerKind::named(&keys.planner).ok_or_else(|| {
        let names = PlannerKind::ALL.map(PlannerKind::name).join(", ");
        let message = format!("no planner `{}`", keys.planner);
        Problem::new(format!("{table}.planner"), message, format!("one of {names}"))
    })?;
    if !(0.8..=1.2).contains(&keys.mean_speed) {
        let message = format!("{} is out of range", keys.mean_speed);
        let expected = "the mean speed over the set speed, from 0.8 to 1.2";
        return Err(Problem::new(format!("{table}.mean_speed"), message, expected));
    }
    let preset = Preset::named(scenario.plant.vehicle.as_str()).unwrap_or(Preset::Jh6At49T);
    let settings = Settings::new(&Truck::preset(preset), planner);
    Ok(Box::new(Predictive::new(&Settings { mean_speed: keys.mean_speed, ..settings })))
}

/// Reads and verifies a design file; a relative path starts at the working directory.
fn load_design(path: &toml::Value) -> Result<Design, String> {
    let path = path.as_str().ok_or("the path of a design is a string")?;
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    Design::load(&text).map_err(|error| format!("{path}: {error}"))
}

/// The law's own table as its type.
fn read_table<T: DeserializeOwned>(table: &toml::Table, path: &str) -> Result<T, Problem> {
    table.clone().try_into().map_err(|error: toml::de::Error| {
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        Problem::new(path, message, "the keys of the law, with values of their types")
    })
}

/// The predictive laws' settings from the scenario's keys.
fn predictive_config(controller: &Controller) -> Result<Config, Problem> {
    let mut road: RoadConfig = read_table(&controller.road, "controller.road")?;
    road.standstill_gap_m = controller.standstill_distance_m.value();
    let weights = &controller.weights;
    Ok(Config {
        spacing_policy: match controller.spacing_policy {
            ScenarioPolicy::ConstantDistance => SpacingPolicy::ConstantDistance,
            ScenarioPolicy::MeasuredHeadway => SpacingPolicy::MeasuredHeadway,
            ScenarioPolicy::ConstantTimeHeadway => SpacingPolicy::ConstantTimeHeadway,
        },
        solver: match controller.solver {
            controller::Solver::Riccati => SolverKind::Riccati,
            controller::Solver::Clarabel => SolverKind::Clarabel,
        },
        horizon_steps: controller.horizon.value().into(),
        step_s: f64::from(controller.prediction_step().value()) / 1e3,
        actuator_lag_s: controller.model_time_constant_s.value(),
        min_request_mps2: controller.min_request_mps2.value(),
        max_request_mps2: controller.max_request_mps2.value(),
        time_headway_s: controller.time_headway_s.value(),
        buffer_m: controller.standstill_distance_m.value(),
        weight_set: WeightSet::Custom,
        weights: Some(Weights {
            gap_error_per_m2: weights.q1.value(),
            speed_error_s2_per_m2: weights.q2.value(),
            acceleration_s4_per_m2: weights.q3.value(),
            request_s4_per_m2: weights.r.value(),
            light_m: weights.light_weight.value(),
            light_threshold_m: weights.light_threshold_m.value(),
        }),
        road,
    })
}

/// A refused setting under the name that it has in a scenario file.
fn config_problem(error: &ConfigError, controller: &Controller) -> Problem {
    let key = match error {
        ConfigError::Range { key, .. }
        | ConfigError::Limits { key, .. }
        | ConfigError::Missing(key)
        | ConfigError::Conflict(key, _) => *key,
    };
    let path = match key {
        "horizon_steps" => "horizon",
        "step_s" if controller.prediction_step_ms.is_some() => "prediction_step_ms",
        "step_s" => "period_ms",
        "actuator_lag_s" => "model_time_constant_s",
        "buffer_m" | "road.standstill_gap_m" => "standstill_distance_m",
        other => other,
    };
    let expected = match error {
        ConfigError::Range { expected, .. } => (*expected).to_owned(),
        ConfigError::Limits { min, max, .. } => format!("{min} to {max}"),
        ConfigError::Missing(_) | ConfigError::Conflict(..) => "one set of weights".to_owned(),
    };
    Problem::new(format!("controller.{path}"), error.to_string(), expected)
}
