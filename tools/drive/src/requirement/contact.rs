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

/// A driver who has noticed the need to brake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceDriver {
    /// Time from the need to the braking, s.
    pub reaction_s: f64,
    pub deceleration_mps2: f64,
    /// Growth of the deceleration, m/s³; infinite: at once.
    pub jerk_mps3: f64,
}

impl ReferenceDriver {
    /// 6 m/s², 0.35 s after the need (UN R157, annex 4, appendix 3).
    pub const REGULATION: Self =
        Self { reaction_s: 0.35, deceleration_mps2: 6.0, jerk_mps3: f64::INFINITY };
    /// The careful driver of UN R157, annex 4, appendix 3: 0.774 g after 0.75 s, reached in 0.6 s.
    pub const CAREFUL: Self = Self { reaction_s: 0.75, deceleration_mps2: 7.59, jerk_mps3: 12.65 };
    /// Braking beyond which there is a need, m/s². Chosen: the plant's own stop in lane by default.
    pub const NEED_MPS2: f64 = 2.5;

    /// The driver of a vehicle whose brakes give at most this much.
    pub fn with_brakes(self, hardest_mps2: f64) -> Self {
        Self { deceleration_mps2: self.deceleration_mps2.min(hardest_mps2), ..self }
    }

    /// Deceleration at a time after the need, m/s². `None` in the reaction time.
    ///
    /// ```
    /// use drive::ReferenceDriver;
    ///
    /// assert_eq!(ReferenceDriver::REGULATION.braking_mps2(0.3), None);
    /// assert_eq!(ReferenceDriver::REGULATION.braking_mps2(0.35), Some(6.0));
    /// assert_eq!(ReferenceDriver::CAREFUL.braking_mps2(1.5), Some(7.59));
    /// ```
    pub fn braking_mps2(&self, since_need_s: f64) -> Option<f64> {
        // The rounding of a sum of steps is not a delay.
        let braked_s = since_need_s - self.reaction_s;
        if braked_s < -1e-9 {
            return None;
        }
        if self.jerk_mps3.is_infinite() {
            return Some(self.deceleration_mps2);
        }
        Some((self.jerk_mps3 * braked_s.max(0.0)).min(self.deceleration_mps2))
    }
}
