//! The model-predictive laws `acc-mpc` and `cacc-mpc` (He, Xi, Huang, Chen and Huang, 2024,
//! doi 10.3969/j.issn.2095-1469.2024.06.06).
//!
//! `acc-mpc` follows and ignores signals, `cacc-mpc` uses them. The spacing policy picks the formulation. The paper's
//! own ([`paper`]) reproduces its figures. The one for the road ([`road`]) is the default.

pub mod config;
pub mod paper;
mod plan;
pub mod road;

pub use config::Signals;

use mpc_solver::ProblemError;
use scenario::controller::{Controller, SpacingPolicy};
use scenario::quantity::Distance;
use scenario::referee::DesiredGap;
use scenario::{Problem, Scenario};

use self::config::{Config, TABLE};
use self::paper::PaperLaw;
use self::road::RoadLaw;
use law::{Descriptor, Formulation, GapPolicy, Law, Reader};

/// Model-predictive following.
pub static ACC_MPC: Descriptor = descriptor(
    "acc-mpc",
    "predictive following, blind to signals (He et al. 2024, baseline)",
    |reader| Ok(of(reader, Signals::Ignored)?.0),
);

/// The same with signalised intersections.
pub static CACC_MPC: Descriptor = descriptor(
    "cacc-mpc",
    "predictive following through signalised intersections (He et al. 2024)",
    |reader| Ok(of(reader, Signals::Used)?.0),
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

/// Builds a law from its settings; the spacing policy picks the formulation.
///
/// # Errors
/// A key, relative to `controller`, whose value is not accepted.
pub fn build(signals: Signals, config: &Config) -> Result<Box<dyn Law + Send>, Problem> {
    config.check()?;
    let uses_light = signals == Signals::Used;
    let solver = config.create_solver();
    let not_convex = |error: ProblemError| {
        Problem::new("weights", error.to_string(), "weights of a convex problem")
    };
    if config.spacing_policy == SpacingPolicy::ConstantTimeHeadway {
        return Ok(Box::new(RoadLaw::new(config, uses_light, solver).map_err(not_convex)?));
    }
    Ok(Box::new(PaperLaw::new(config, uses_light, solver).map_err(not_convex)?))
}

/// The law of a scenario, and its settings.
pub(super) fn of(
    reader: &Reader<'_>,
    signals: Signals,
) -> Result<(Box<dyn Law + Send>, Config), Problem> {
    let config = Config::of(reader, signals)?;
    let law = build(signals, &config)
        .map_err(|problem| Config::in_scenario(problem, &reader.scenario.controller))?;
    Ok((law, config))
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
