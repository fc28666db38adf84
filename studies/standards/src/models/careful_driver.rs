//! `careful-driver`: the competent and careful human driver of UN R157, annex 4, appendix 3.
//!
//! The driver recognises a cut-in when the other's side reaches the ego's (`s <= 0`). The driver perceives the risk if
//! the time to collision is then at most 2 s. Otherwise he need not react. The pedal is released for 0.75 s (0.4 m/s²).
//! Then the deceleration grows by 12.65 m/s³ to 0.774 g.

use super::braking::Braking;
use super::{Situation, View};
use crate::GRAVITY_MPS2;

/// 0.75 s in whole steps.
pub(super) const REACTION_STEPS: u32 = 8;
/// Deceleration with the pedal released \[m/s²\].
pub(super) const PEDAL_RELEASED_MPS2: f64 = 0.4;
/// An attentive driver's full braking, which RSS and the fuzzy model share.
pub(super) const FULL_BRAKING: Braking =
    Braking { deceleration_mps2: 0.774 * GRAVITY_MPS2, growth_mps3: 12.65 };

const PERCEIVED_TIME_TO_COLLISION_S: f64 = 2.0;
const TIME_GAP_S: f64 = 2.0;

/// The distance that a careful driver keeps \[m\].
pub(super) fn following_distance_m(speed_mps: f64) -> f64 {
    TIME_GAP_S * speed_mps
}

/// True if the driver has recognised the risk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recognition {
    /// The other has not reached the ego's path.
    Waiting,
    /// The driver reacts.
    Risk,
    /// There was time enough when the other arrived.
    NotNeeded,
}

impl Recognition {
    pub(super) fn new(situation: Situation) -> Recognition {
        match situation {
            Situation::CutIn => Recognition::Waiting,
            Situation::InLane => Recognition::Risk,
        }
    }

    pub(super) fn needs_no_reaction(self) -> bool {
        self == Recognition::NotNeeded
    }

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
