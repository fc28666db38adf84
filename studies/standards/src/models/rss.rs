//! `rss`: responsibility-sensitive safety (Shalev-Shwartz and others 2017).
//!
//! Braking is due while both distances are too short. `t` is the response time, `a` the acceleration in it, `b` the
//! braking of both vehicles, `l` the lateral acceleration:
//!
//! ```text
//! d < v t + a t²/2 + (v + a t)²/(2b) - v_o²/(2b)
//! s < 0.3 m + (2w + l t) t/2 + (w + l t)²/(2l)
//! ```

use super::un_r157::FULL_BRAKING;
use super::{Braking, View};

const RESPONSE_S: f64 = 0.75;
const ACCELERATION_MPS2: f64 = 3.0;
const BRAKING_MPS2: f64 = 6.0;
const LATERAL_ACCELERATION_MPS2: f64 = 1.0;
const LATERAL_MARGIN_M: f64 = 0.3;

pub(super) fn trigger(speed_mps: f64, view: &View) -> Option<Braking> {
    let is_near = view.gap_m < safe_distance_m(speed_mps, view.other_speed_mps)
        && view.clearance_m < safe_clearance_m(view.lateral_speed_mps);
    is_near.then_some(FULL_BRAKING)
}

/// Distance that the model keeps behind a vehicle of the same speed \[m\]. It is the safe one, and
/// the model's way in the response time.
pub(super) fn following_distance_m(speed_mps: f64) -> f64 {
    safe_distance_m(speed_mps, speed_mps) + speed_mps * RESPONSE_S
}

/// The safe longitudinal distance \[m\], at least 0.
fn safe_distance_m(speed_mps: f64, other_speed_mps: f64) -> f64 {
    let fastest_mps = speed_mps + ACCELERATION_MPS2 * RESPONSE_S;
    let distance_m = speed_mps * RESPONSE_S
        + ACCELERATION_MPS2 * RESPONSE_S * RESPONSE_S / 2.0
        + fastest_mps * fastest_mps / (2.0 * BRAKING_MPS2)
        - other_speed_mps * other_speed_mps / (2.0 * BRAKING_MPS2);
    distance_m.max(0.0)
}

/// The safe lateral distance from a vehicle that comes closer with `lateral_speed_mps` \[m\].
fn safe_clearance_m(lateral_speed_mps: f64) -> f64 {
    let gained_mps = LATERAL_ACCELERATION_MPS2 * RESPONSE_S;
    let fastest_mps = lateral_speed_mps + gained_mps;
    LATERAL_MARGIN_M
        + (2.0 * lateral_speed_mps + gained_mps) * RESPONSE_S / 2.0
        + fastest_mps * fastest_mps / (2.0 * LATERAL_ACCELERATION_MPS2)
}
