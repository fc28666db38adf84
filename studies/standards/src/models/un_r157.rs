//! The two models of UN R157: the driver of annex 4, appendix 3, and the system of paragraph 5.2.5.2.
//!
//! * `careful-driver` recognises a cut-in when the other's side reaches the ego's (`s <= 0`). The driver perceives the
//!   risk if the time to collision is then at most 2 s. Otherwise he need not react. The pedal is released for 0.75 s
//!   (0.4 m/s²). Then the deceleration grows by 12.65 m/s³ to 0.774 g.
//! * `regulation`: the time to collision counts when the other is 0.5 m or less away laterally (0.3 m inside the lane).
//!   A collision must be avoided unless this time is below `(v - v_o)/(2·6) + 0.35 s`. The model decides at 0.1 s above
//!   that limit and brakes 0.35 s later, with 6 m/s² at once. Beside the other the distance counts by its magnitude.

use super::{Braking, View};
use crate::GRAVITY_MPS2;

/// Reaction time of a driver, 0.75 s, in whole steps.
pub(super) const DRIVER_STEPS: u32 = 8;
/// Deceleration with the pedal released \[m/s²\].
pub(super) const PEDAL_RELEASED_MPS2: f64 = 0.4;
/// An attentive driver's full braking, which RSS and the fuzzy model share.
pub(super) const FULL_BRAKING: Braking =
    Braking { deceleration_mps2: 0.774 * GRAVITY_MPS2, growth_mps3: 12.65 };
const PERCEIVED_TIME_TO_COLLISION_S: f64 = 2.0;
/// Time gap that a careful driver keeps \[s\].
pub(super) const TIME_GAP_S: f64 = 2.0;

/// Reaction time of the system, 0.35 s, in whole steps.
pub(super) const SYSTEM_STEPS: u32 = 4;
const DECELERATION_MPS2: f64 = 6.0;
const REACTION_S: f64 = 0.35;
const MARGIN_S: f64 = 0.1;
const CLEARANCE_M: f64 = 0.5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recognition {
    /// The other has not reached the ego's path.
    Waiting,
    Risk,
    /// There was time enough when the other arrived.
    NotNeeded,
}

impl Recognition {
    pub(super) fn trigger(&mut self, speed_mps: f64, view: &View) -> Option<Braking> {
        if *self == Recognition::Waiting && view.clearance_m <= 0.0 {
            let closing_mps = speed_mps - view.other_speed_mps;
            let perceived =
                closing_mps > 0.0 && view.gap_m / closing_mps <= PERCEIVED_TIME_TO_COLLISION_S;
            *self = if perceived { Recognition::Risk } else { Recognition::NotNeeded };
        }
        (*self == Recognition::Risk).then_some(FULL_BRAKING)
    }
}

pub(super) fn trigger(speed_mps: f64, view: &View) -> Option<Braking> {
    let closing_mps = speed_mps - view.other_speed_mps;
    let limit_s = closing_mps / (2.0 * DECELERATION_MPS2) + REACTION_S + MARGIN_S;
    let is_near = view.clearance_m <= CLEARANCE_M
        && closing_mps > 0.0
        && view.gap_m.abs() / closing_mps < limit_s;
    is_near.then_some(Braking { deceleration_mps2: DECELERATION_MPS2, growth_mps3: f64::INFINITY })
}
