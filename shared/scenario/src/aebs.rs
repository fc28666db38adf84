//! `[aebs]`: the advanced emergency braking system and the brakes that it acts on.

use serde::{Deserialize, Serialize};

use super::quantity::{AccelerationMagnitude, DelayMs, Distance, JerkMagnitude, Time};

/// Least deceleration that an emergency brake must have, m/s² (UN R152, paragraph 5.2.1.4).
pub const LEAST_DECELERATION_MPS2: f64 = 5.0;

/// The emergency brake: a process of its own that reads the radar's detections, and a brake path of its
/// own in the plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Aebs {
    /// Whether it is on; absent: on where the radar gives detections.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub enabled: Option<bool>,
    /// Time from its request until the deceleration begins to grow, ms.
    pub dead_time_ms: DelayMs,
    /// Growth of the deceleration, m/s³.
    pub jerk_mps3: JerkMagnitude,
    /// Largest deceleration, m/s².
    pub deceleration_mps2: AccelerationMagnitude,
    /// Distance to be left to what it brakes for, m.
    pub margin_m: Distance,
    /// Time by which the warning comes before the braking, where there is time, s.
    pub warning_s: Time,
    /// Longest time over which a vehicle's lateral motion is carried on, s.
    pub lateral_horizon_s: Time,
    /// Deadline of its cycle after the scheduled release, ms.
    pub deadline_ms: DelayMs,
}

impl Default for Aebs {
    fn default() -> Self {
        Self {
            enabled: None,
            dead_time_ms: DelayMs::of(100),
            jerk_mps3: JerkMagnitude::of(12.65),
            deceleration_mps2: AccelerationMagnitude::of(8.34),
            margin_m: Distance::of(0.8),
            warning_s: Time::of(0.8),
            lateral_horizon_s: Time::of(3.0),
            deadline_ms: DelayMs::of(50),
        }
    }
}
