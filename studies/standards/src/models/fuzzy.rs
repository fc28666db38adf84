//! `fuzzy`: the fuzzy safety model of the European Commission's Joint Research Centre (Mattas and
//! others 2020).
//!
//! Two measures between 0 and 1, each linear between a safe and an unsafe distance. With the reaction
//! time `t`, comfortable and hard braking (4 and 6 m/s²) and the other's braking (7 m/s²):
//!
//! * proactive `P`, on `d - 2 m`: `v t + v²/(2·4) - v_o²/(2·7) + 2 m`, unsafe with 6 in place of 4;
//! * critical `C`, while the ego is faster: with `a' = max(a, -4)` and `v' = v + a' t` it is
//!   `(v + a' t/2 - v_o) t + (v' - v_o)²/(2·4)`, unsafe with 6. If `v' < v_o` it is 1 when
//!   `d < (v - v_o)²/|2a|`, else 0.
//!
//! Deceleration: `C·(6 - 4) + 4` if `C > 0`, else `4·P`. A vehicle beside the lane counts only if it
//! arrives before the ego has passed it.

use super::un_r157::FULL_BRAKING;
use super::{Braking, View};
use crate::VEHICLE_LENGTH_M;

const REACTION_S: f64 = 0.75;
const COMFORTABLE_MPS2: f64 = 4.0;
const HARD_MPS2: f64 = 6.0;
const OTHER_MPS2: f64 = 7.0;
const SAFE_DISTANCE_MARGIN_M: f64 = 2.0;
const DISTANCE_MARGIN_M: f64 = 2.0;
const ARRIVAL_MARGIN_S: f64 = 0.1;

pub(super) fn trigger(speed_mps: f64, acceleration_mps2: f64, view: &View) -> Option<Braking> {
    if !crosses_the_path(speed_mps, view) {
        return None;
    }
    let critical = critical(speed_mps, acceleration_mps2, view);
    let deceleration_mps2 = if critical > 0.0 {
        critical * (HARD_MPS2 - COMFORTABLE_MPS2) + COMFORTABLE_MPS2
    } else {
        COMFORTABLE_MPS2 * proactive(speed_mps, view)?
    };
    Some(Braking {
        deceleration_mps2: deceleration_mps2.min(FULL_BRAKING.deceleration_mps2),
        growth_mps3: FULL_BRAKING.growth_mps3,
    })
}

/// The distance at which the proactive measure begins behind a vehicle of the same speed \[m\].
pub(super) fn following_distance_m(speed_mps: f64) -> f64 {
    proactive_distance_m(speed_mps, speed_mps, COMFORTABLE_MPS2)
}

/// True if the other is in the lane, or will be before the ego has passed.
fn crosses_the_path(speed_mps: f64, view: &View) -> bool {
    let closing_mps = speed_mps - view.other_speed_mps;
    view.clearance_m <= 0.0
        || (view.lateral_speed_mps > 0.0
            && closing_mps > 0.0
            && view.clearance_m / view.lateral_speed_mps
                < (view.gap_m + 2.0 * VEHICLE_LENGTH_M) / closing_mps + ARRIVAL_MARGIN_S)
}

/// The proactive measure; `None` above the safe distance. At it, where a vehicle that follows is, the
/// measure is 0 and the reaction time begins.
fn proactive(speed_mps: f64, view: &View) -> Option<f64> {
    let safe_m = proactive_distance_m(speed_mps, view.other_speed_mps, COMFORTABLE_MPS2);
    let unsafe_m = proactive_distance_m(speed_mps, view.other_speed_mps, HARD_MPS2);
    (view.gap_m <= safe_m).then(|| membership(view.gap_m, safe_m, unsafe_m))
}

fn proactive_distance_m(speed_mps: f64, other_speed_mps: f64, braking_mps2: f64) -> f64 {
    speed_mps * REACTION_S + speed_mps * speed_mps / (2.0 * braking_mps2)
        - other_speed_mps * other_speed_mps / (2.0 * OTHER_MPS2)
        + SAFE_DISTANCE_MARGIN_M
        + DISTANCE_MARGIN_M
}

fn critical(speed_mps: f64, acceleration_mps2: f64, view: &View) -> f64 {
    let closing_mps = speed_mps - view.other_speed_mps;
    if closing_mps <= 0.0 {
        return 0.0;
    }
    let expected_mps2 = acceleration_mps2.max(-COMFORTABLE_MPS2);
    let later_mps = speed_mps + expected_mps2 * REACTION_S - view.other_speed_mps;
    if later_mps < 0.0 {
        let needed_m = closing_mps * closing_mps / (2.0 * acceleration_mps2).abs();
        return if view.gap_m < needed_m { 1.0 } else { 0.0 };
    }
    let travelled_m = (closing_mps + expected_mps2 * REACTION_S / 2.0) * REACTION_S;
    membership(
        view.gap_m,
        travelled_m + later_mps * later_mps / (2.0 * COMFORTABLE_MPS2),
        travelled_m + later_mps * later_mps / (2.0 * HARD_MPS2),
    )
}

/// 0 above `safe_m`, 1 below `unsafe_m`, linear between them.
fn membership(distance_m: f64, safe_m: f64, unsafe_m: f64) -> f64 {
    if distance_m >= safe_m {
        0.0
    } else if distance_m < unsafe_m {
        1.0
    } else {
        (safe_m - distance_m) / (safe_m - unsafe_m)
    }
}
