//! Figures of the emergency brake.

use crate::report::{Details, Hops, PlantReport, ServiceReport};
use runtime::statistics::Percentiles;
use scenario::Scenario;
use serde::Serialize;

/// The emergency brake in a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Aebs {
    /// True if the scenario has an emergency brake.
    pub enabled: bool,
    /// Number of warnings to the driver; null without an emergency brake.
    pub warnings: Option<u64>,
    pub interventions: Option<u64>,
    /// Time for which it braked or held the brakes, s.
    pub braking_s: Option<f64>,
    /// Time without an emergency brake or without its radar, s.
    pub unavailable_s: Option<f64>,
    /// Radar acquisition to the first cycle of the brake path that uses it, µs.
    pub reaction_time_us: Option<Percentiles>,
    /// Parts of the reaction time.
    pub hops_us: Hops,
    /// Deadline of its cycle after the scheduled release, µs.
    pub deadline_us: Option<f64>,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: Option<u64>,
    /// Time to track objects and decide, µs.
    pub decide_us: Option<Percentiles>,
}

/// Number of interventions, in words.
pub fn braked(interventions: u64) -> String {
    match interventions {
        0 => "the emergency brake never braked".into(),
        1 => "the emergency brake braked once".into(),
        times => format!("the emergency brake braked {times} times"),
    }
}

impl Aebs {
    pub(super) fn of(
        scenario: &Scenario,
        plant: Option<&PlantReport>,
        report: Option<&ServiceReport>,
    ) -> Self {
        let figures = plant.and_then(|plant| plant.aebs.as_ref());
        let own = report.and_then(|report| match &report.details {
            Details::Aebs(aebs) => Some(aebs),
            _ => None,
        });
        Self {
            enabled: scenario.has_aebs(),
            warnings: figures.map(|figures| figures.warnings),
            interventions: figures.map(|figures| figures.interventions),
            braking_s: figures.map(|figures| figures.braking_s),
            unavailable_s: figures.map(|figures| figures.unavailable_s),
            reaction_time_us: plant.and_then(|plant| plant.brake_reaction_time_us),
            hops_us: plant.map_or_else(Hops::default, |plant| plant.brake_hops_us),
            deadline_us: own.map(|own| own.deadline_us),
            deadline_misses: own.map(|own| own.deadline_misses),
            decide_us: own.and_then(|own| own.decide_us),
        }
    }
}
