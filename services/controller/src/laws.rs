//! Which law a scenario asks for, and with what parameters.

use crate::cacc::config::{Config, ConfigError, SolverKind, SpacingPolicy};
use crate::cacc::weights::{WeightSet, Weights};
use crate::cacc::{self, BuildError};
use crate::law::Law;
use shared::scenario::controller::{
    self, Controller, ControllerName, SpacingPolicy as ScenarioPolicy,
};
use shared::scenario::{Problem, Scenario};

/// What a law is, in one line.
#[must_use]
pub fn describe(name: ControllerName) -> &'static str {
    match name {
        ControllerName::AccMpc => "predictive following, blind to signals (He et al. 2024, baseline)",
        ControllerName::CaccMpc => {
            "predictive following through signalised intersections (He et al. 2024)"
        }
        ControllerName::SixMode => "six switched modes (Wang et al. 2014)",
        ControllerName::QuadraticBounded => {
            "output feedback that keeps all indices within bounds (Gao et al. 2015)"
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
        ControllerName::SixMode | ControllerName::QuadraticBounded => Err(Problem::new("controller.name", "not built yet", "acc-mpc or cacc-mpc")),
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

fn predictive(
    which: cacc::Controller,
    controller: &Controller,
) -> Result<Box<dyn Law>, Problem> {
    let config = predictive_config(controller)?;
    match cacc::build(which, &config) {
        Ok(law) => Ok(law),
        Err(BuildError::Config(error)) => Err(config_problem(&error)),
        Err(BuildError::Problem(error)) => {
            Err(Problem::new("controller", error.to_string(), "weights of a convex problem"))
        }
    }
}

/// The predictive laws' settings from the scenario's keys.
fn predictive_config(controller: &Controller) -> Result<Config, Problem> {
    let road = controller.road.clone().try_into().map_err(|error| {
        Problem::new("controller.road", error_line(&error), "the keys of the road formulation")
    })?;
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
        step_s: f64::from(controller.period_ms.value()) / 1e3,
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
fn config_problem(error: &ConfigError) -> Problem {
    let key = match error {
        ConfigError::Range { key, .. }
        | ConfigError::Limits { key, .. }
        | ConfigError::Missing(key)
        | ConfigError::Conflict(key, _) => *key,
    };
    let path = match key {
        "horizon_steps" => "horizon",
        "step_s" => "period_ms",
        "actuator_lag_s" => "model_time_constant_s",
        "buffer_m" => "standstill_distance_m",
        other => other,
    };
    let expected = match error {
        ConfigError::Range { expected, .. } => (*expected).to_owned(),
        ConfigError::Limits { min, max, .. } => format!("{min} to {max}"),
        ConfigError::Missing(_) | ConfigError::Conflict(..) => "one set of weights".to_owned(),
    };
    Problem::new(format!("controller.{path}"), error.to_string(), expected)
}

fn error_line(error: &toml::de::Error) -> String {
    error.message().lines().collect::<Vec<_>>().join(" ")
}
