//! The model-predictive laws `acc-mpc` and `cacc-mpc` (He, Xi, Huang, Chen and Huang, 2024,
//! doi 10.3969/j.issn.2095-1469.2024.06.06).
//!
//! `acc-mpc` follows and ignores signals, `cacc-mpc` uses them. The spacing policy picks the
//! formulation: the paper's own ([`paper`]), which its figures need, or the one for the road
//! ([`road`]), which is the default.

pub mod config;
pub mod driver;
pub mod kinematics;
pub mod paper;
mod plan;
pub mod published;
pub mod road;
pub mod scenes;
pub mod weights;

use std::fmt;

use mpc_solver::ProblemError;

use crate::law::Law;
use config::{Config, ConfigError, SpacingPolicy};
use paper::PaperLaw;
use road::RoadLaw;

/// Which of the two laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// `acc-mpc`: follows, ignores signals.
    AccMpc,
    /// `cacc-mpc`: follows and uses signals.
    CaccMpc,
}

/// Why a law could not be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildError {
    /// A setting is not accepted.
    Config(ConfigError),
    /// The settings do not make a convex program.
    Problem(ProblemError),
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(error) => error.fmt(f),
            Self::Problem(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for BuildError {}

impl From<ConfigError> for BuildError {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

impl From<ProblemError> for BuildError {
    fn from(error: ProblemError) -> Self {
        Self::Problem(error)
    }
}

/// Builds a law from its settings; the spacing policy picks the formulation.
///
/// # Errors
/// [`BuildError`] when a setting is out of range or the weights make no convex program.
pub fn build(controller: Controller, config: &Config) -> Result<Box<dyn Law + Send>, BuildError> {
    config.validate()?;
    let uses_light = controller == Controller::CaccMpc;
    let solver = config.solver.create(config.horizon_steps);
    if config.spacing_policy == SpacingPolicy::ConstantTimeHeadway {
        return Ok(Box::new(RoadLaw::new(config, uses_light, solver)?));
    }
    let weights = config.paper_weights().ok_or(ConfigError::Missing("weights"))?;
    Ok(Box::new(PaperLaw::new(config, &weights, uses_light, solver)?))
}
