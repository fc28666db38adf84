//! `regulation`: the system of UN R157, paragraph 5.2.5.2.
//!
//! The time to collision counts when the other is 0.5 m or less away laterally (0.3 m inside the lane). A collision
//! must be avoided unless this time is below `(v - v_o)/(2·6) + 0.35 s`. The model decides at 0.1 s above that limit
//! and brakes 0.35 s later, with 6 m/s² at once. Beside the other the distance counts by its magnitude.

use super::View;
use super::braking::Braking;

/// 0.35 s in whole steps.
pub(super) const REACTION_STEPS: u32 = 4;

const DECELERATION_MPS2: f64 = 6.0;
const REACTION_S: f64 = 0.35;
const MARGIN_S: f64 = 0.1;
const CLEARANCE_M: f64 = 0.5;

pub(super) fn trigger(speed_mps: f64, view: &View) -> Option<Braking> {
    let closing_mps = speed_mps - view.other_speed_mps;
    let limit_s = closing_mps / (2.0 * DECELERATION_MPS2) + REACTION_S + MARGIN_S;
    let is_near = view.clearance_m <= CLEARANCE_M
        && closing_mps > 0.0
        && view.gap_m.abs() / closing_mps < limit_s;
    is_near.then_some(Braking { deceleration_mps2: DECELERATION_MPS2, growth_mps3: f64::INFINITY })
}
