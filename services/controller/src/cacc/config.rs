//! Settings of the two model-predictive laws.

use std::fmt;

use mpc_solver::{Kind, Solver};
use serde::{Deserialize, Serialize};

use super::road::RoadConfig;
use super::weights::{WeightSet, Weights};
use crate::law::MAX_PLAN;

/// How the desired distance is formed, and with it the formulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpacingPolicy {
    /// The paper's plant: the desired distance keeps its first value for the whole run.
    ConstantDistance,
    /// The paper's Table 3: `d_s = t_h v + d_b` is measured anew in each cycle, and predicted with
    /// the paper's model, which leaves `t_h a` out of the error's rate.
    MeasuredHeadway,
    /// Constant time headway, predicted exactly: the formulation for the road.
    #[default]
    ConstantTimeHeadway,
}

/// Solver of the convex programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverKind {
    /// The stage-wise interior point made for these problems.
    #[default]
    Riccati,
    /// The general conic solver.
    Clarabel,
}

impl SolverKind {
    /// A solver of this kind for a horizon of `horizon` steps.
    #[must_use]
    pub fn create(self, horizon: usize) -> Box<dyn Solver + Send> {
        match self {
            Self::Riccati => Kind::Riccati.create(horizon),
            Self::Clarabel => Kind::Clarabel.create(horizon),
        }
    }
}

/// Settings of `acc-mpc` and `cacc-mpc`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// How the desired distance is formed.
    pub spacing_policy: SpacingPolicy,
    /// Solver of the convex programs.
    pub solver: SolverKind,
    /// Steps of the prediction, `N`.
    pub horizon_steps: usize,
    /// Step of the prediction, `T`, s.
    pub step_s: f64,
    /// Lag of the vehicle's acceleration behind the request, `tau`, s.
    pub actuator_lag_s: f64,
    /// Smallest request, m/s².
    pub min_request_mps2: f64,
    /// Largest request, m/s².
    pub max_request_mps2: f64,
    /// Time headway `t_h`, s.
    pub time_headway_s: f64,
    /// Buffer `d_b`: the desired gap at standstill under the paper's spacing policies, m.
    pub buffer_m: f64,
    /// Weights of the paper's cost, by name.
    pub weight_set: WeightSet,
    /// Weights of the paper's cost in numbers; needs `weight_set = "custom"`.
    pub weights: Option<Weights>,
    /// Settings of the formulation for the road.
    pub road: RoadConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            spacing_policy: SpacingPolicy::default(),
            solver: SolverKind::default(),
            horizon_steps: 100,
            step_s: 0.1,
            actuator_lag_s: 0.5,
            min_request_mps2: -4.9,
            max_request_mps2: 4.9,
            time_headway_s: 1.5,
            buffer_m: 12.0,
            weight_set: WeightSet::default(),
            weights: None,
            road: RoadConfig::default(),
        }
    }
}

impl Config {
    /// The paper's cost as configured; `None` when a custom set is announced but not given.
    #[must_use]
    pub fn paper_weights(&self) -> Option<Weights> {
        self.weight_set.weights().or(self.weights)
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// Names the first key that is out of range and what it must be.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let n = self.horizon_steps;
        if !(10..=MAX_PLAN).contains(&n) {
            return Err(ConfigError::range("horizon_steps", "10 to 128", n as f64));
        }
        in_range("step_s", self.step_s, 0.01, 0.5)?;
        in_range("actuator_lag_s", self.actuator_lag_s, 0.05, 5.0)?;
        if self.step_s >= self.actuator_lag_s {
            return Err(ConfigError::range("step_s", "below actuator_lag_s", self.step_s));
        }
        in_range("min_request_mps2", self.min_request_mps2, -12.0, -0.5)?;
        in_range("max_request_mps2", self.max_request_mps2, 0.5, 12.0)?;
        in_range("time_headway_s", self.time_headway_s, 0.3, 5.0)?;
        in_range("buffer_m", self.buffer_m, 0.5, 50.0)?;
        match (self.weight_set, &self.weights) {
            (WeightSet::Custom, None) => return Err(ConfigError::Missing("weights")),
            (WeightSet::Custom, Some(weights)) => weights.validate()?,
            (_, Some(_)) => return Err(ConfigError::Conflict("weights", "weight_set")),
            (_, None) => {}
        }
        self.road.validate(self.min_request_mps2, self.max_request_mps2)
    }
}

/// Why a configuration is not accepted. Keys are relative to the controller's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// A number is out of its range.
    Range {
        /// The key.
        key: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        value: f64,
    },
    /// A number is outside of two fixed limits.
    Limits {
        /// The key.
        key: &'static str,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// What it is.
        value: f64,
    },
    /// A key that the others call for is missing.
    Missing(&'static str),
    /// A key that contradicts another one.
    Conflict(&'static str, &'static str),
}

impl ConfigError {
    pub(super) fn range(key: &'static str, expected: &'static str, value: f64) -> Self {
        Self::Range { key, expected, value }
    }
}

/// Accepts `min <= value <= max`; NaN is refused.
pub(super) fn in_range(
    key: &'static str,
    value: f64,
    min: f64,
    max: f64,
) -> Result<(), ConfigError> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(ConfigError::Limits { key, min, max, value })
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range { key, expected, value } => {
                write!(f, "`{key}` is {value}; it must be {expected}")
            }
            Self::Limits { key, min, max, value } => {
                write!(f, "`{key}` is {value}; it must lie between {min} and {max}")
            }
            Self::Missing(key) => write!(f, "`{key}` is missing"),
            Self::Conflict(key, other) => {
                write!(f, "`{key}` is given although `{other}` names another set")
            }
        }
    }
}

impl std::error::Error for ConfigError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid() {
        assert_eq!(Config::default().validate(), Ok(()));
    }

    #[test]
    fn nan_and_contradictions_are_refused() {
        let nan = Config { actuator_lag_s: f64::NAN, ..Config::default() };
        assert!(nan.validate().is_err());
        let both = Config { weights: Some(super::super::weights::JOINT), ..Config::default() };
        assert_eq!(both.validate(), Err(ConfigError::Conflict("weights", "weight_set")));
        let none = Config { weight_set: WeightSet::Custom, ..Config::default() };
        assert_eq!(none.validate(), Err(ConfigError::Missing("weights")));
    }

    #[test]
    fn unknown_keys_are_refused() {
        let error = serde_json::from_str::<Config>(r#"{"time_headway": 1.5}"#).unwrap_err();
        assert!(error.to_string().contains("unknown field `time_headway`"));
        let parsed: Config = serde_json::from_str(r#"{"spacing_policy": "constant-distance"}"#)
            .expect("a known key with a known value");
        assert_eq!(parsed.spacing_policy, SpacingPolicy::ConstantDistance);
    }
}
