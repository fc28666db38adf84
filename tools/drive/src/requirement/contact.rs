//! `no-collision`: the least gap, or minus the impact speed after a contact.

use super::evidence::{Evidence, Finding};
use super::others::{Other, Others};
use crate::DriveStep;
use temporal_logic::Unit;

/// The instant at which the ego was nearest to another vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub step: usize,
    pub other: Other,
    pub gap_m: f64,
}

impl Closest {
    /// The closest instant of a drive, or that of its contact; `None` if no other vehicle was ever in lane.
    pub(super) fn of(evidence: &Evidence<'_>, others: &Others<'_>) -> Option<Self> {
        let is_contact = evidence.impact_speed_mps.is_some();
        let steps = &evidence.drive.steps;
        let mut closest: Option<Self> = None;
        for (step, ego) in steps.iter().enumerate() {
            let Some(other) = others.nearest(ego.position_m, ego.time_s) else { continue };
            let here = Self { step, other, gap_m: other.rear_m - ego.position_m };
            if is_contact && here.gap_m <= 0.0 {
                return Some(here);
            }
            if closest.is_none_or(|closest| here.gap_m < closest.gap_m) {
                closest = Some(here);
            }
        }
        closest
    }
}

/// The least gap in m, or minus the impact speed in m/s.
pub(super) fn no_collision(evidence: &Evidence<'_>) -> Finding {
    let closest = Closest::of(evidence, &Others::of(evidence));
    finding(evidence, closest.as_ref())
}

/// The finding at the closest instant.
pub(super) fn finding(evidence: &Evidence<'_>, closest: Option<&Closest>) -> Finding {
    let steps = &evidence.drive.steps;
    let time_s = |step: Option<&DriveStep>| step.map_or(0.0, |step| step.time_s);
    match (evidence.impact_speed_mps, closest) {
        (Some(impact_mps), _) => Finding {
            value: -impact_mps,
            unit: Unit::METRE_PER_SECOND,
            time_s: time_s(closest.map_or(steps.last(), |closest| steps.get(closest.step))),
            met: false,
        },
        // The referee judges bodies: a gap along the lane that is used up is not a contact by itself.
        (None, Some(closest)) => Finding {
            value: closest.gap_m.max(0.0),
            time_s: time_s(steps.get(closest.step)),
            ..Finding::UNDECIDED
        },
        (None, None) => Finding::UNDECIDED,
    }
}
