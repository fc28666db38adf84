//! The model-predictive laws `acc-mpc` and `cacc-mpc` (He, Xi, Huang, Chen and Huang, 2024,
//! doi 10.3969/j.issn.2095-1469.2024.06.06).
//!
//! `acc-mpc` follows and ignores signals, `cacc-mpc` uses them. The spacing policy picks the formulation. The paper's
//! own ([`paper`]) reproduces its figures. The one for the road ([`road`]) is the default.

pub mod config;
pub mod paper;
mod plan;
pub mod road;
pub mod road_config;
pub mod weights;

pub use config::Signals;

use mpc_solver::ProblemError;
use scenario::controller::{Controller, SpacingPolicy};
use scenario::quantity::Distance;
use scenario::referee::DesiredGap;
use scenario::{Problem, Scenario};
use thiserror::Error;

use self::config::Config;
use self::paper::PaperLaw;
use self::road::RoadLaw;
use self::road_config::TABLE;
use law::settings::SettingError;
use law::{Descriptor, Formulation, GapPolicy, Law, Reader};

/// Model-predictive following.
pub static ACC_MPC: Descriptor = descriptor(
    "acc-mpc",
    "predictive following, blind to signals (He et al. 2024, baseline)",
    |reader| of(reader, Signals::Ignored),
);

/// The same with signalised intersections.
pub static CACC_MPC: Descriptor = descriptor(
    "cacc-mpc",
    "predictive following through signalised intersections (He et al. 2024)",
    |reader| of(reader, Signals::Used),
);

const FORMULATIONS: &[&Formulation] = &[&road::FORMULATION, &paper::FORMULATION];

const fn descriptor(
    name: &'static str,
    description: &'static str,
    build: fn(&Reader<'_>) -> Result<Box<dyn Law>, Problem>,
) -> Descriptor {
    Descriptor {
        name,
        description,
        source: "He, Xi, Huang, Chen and Huang, 2024, doi 10.3969/j.issn.2095-1469.2024.06.06",
        table: Some(TABLE),
        formulations: FORMULATIONS,
        formulation,
        gap: GapPolicy::Scenario(desired_gap),
        measured_target: false,
        trucks_alone: false,
        build,
    }
}

/// Reason why a law could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BuildError {
    /// A setting is not accepted.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The settings do not make a convex program.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

/// Builds a law from its settings; the spacing policy picks the formulation.
pub fn build(signals: Signals, config: &Config) -> Result<Box<dyn Law + Send>, BuildError> {
    config.check()?;
    let uses_light = signals == Signals::Used;
    let solver = config.create_solver();
    if config.spacing_policy == SpacingPolicy::ConstantTimeHeadway {
        return Ok(Box::new(RoadLaw::new(config, uses_light, solver)?));
    }
    Ok(Box::new(PaperLaw::new(config, uses_light, solver)?))
}

fn formulation(controller: &Controller) -> &'static Formulation {
    match controller.spacing_policy {
        SpacingPolicy::ConstantTimeHeadway => &road::FORMULATION,
        SpacingPolicy::ConstantDistance | SpacingPolicy::MeasuredHeadway => &paper::FORMULATION,
    }
}

pub(super) fn desired_gap(scenario: &Scenario) -> DesiredGap {
    let controller = &scenario.controller;
    let time_headway_s = controller.time_headway_s;
    let standstill_m = controller.standstill_distance_m.value();
    let distance =
        |m: f64| Distance::try_from(m).expect("a headway and a length are within a distance");
    match controller.spacing_policy {
        SpacingPolicy::ConstantDistance => {
            let start_mps = scenario.plant.initial_speed_mps.value();
            DesiredGap::Fixed { gap_m: distance(time_headway_s.value() * start_mps + standstill_m) }
        }
        SpacingPolicy::MeasuredHeadway | SpacingPolicy::ConstantTimeHeadway => {
            let standstill_distance_m = distance(standstill_m);
            DesiredGap::Headway { time_headway_s, standstill_distance_m }
        }
    }
}

fn of(reader: &Reader<'_>, signals: Signals) -> Result<Box<dyn Law>, Problem> {
    let config = Config::of(reader, signals)?;
    match build(signals, &config) {
        Ok(law) => Ok(law),
        Err(error) => Err(in_scenario(error, &reader.scenario().controller)),
    }
}

/// The error in the words and units of the scenario's keys.
pub(super) fn in_scenario(error: BuildError, controller: &Controller) -> Problem {
    match error {
        BuildError::Setting(error) => Config::in_scenario(error, controller).in_table("controller"),
        BuildError::Problem(error) => {
            Problem::new("controller", error.to_string(), "weights of a convex problem")
        }
    }
}
