//! `[controller.curve_speed]`: a cap on the set speed before and in curves.

use serde::{Deserialize, Serialize};

use super::quantity::AccelerationMagnitude;
use super::schema::Schema;

/// Slower driving in curves of a road with a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct CurveSpeed {
    /// True if the set speed is capped.
    pub enabled: bool,
    /// Lateral acceleration that the cap keeps, m/s².
    pub comfort_mps2: Comfort,
    /// Deceleration with which the speed falls before a curve, m/s².
    pub braking_mps2: AccelerationMagnitude,
}

/// Lateral acceleration by speed: `slow` up to 17 m/s, `fast` from 32 m/s on, between them in proportion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Comfort {
    /// Up to 17 m/s, m/s².
    pub slow: AccelerationMagnitude,
    /// From 32 m/s on, m/s².
    pub fast: AccelerationMagnitude,
}

impl Default for CurveSpeed {
    fn default() -> Self {
        Self {
            enabled: true,
            comfort_mps2: Comfort::default(),
            braking_mps2: AccelerationMagnitude::of(1.0),
        }
    }
}

impl Default for Comfort {
    fn default() -> Self {
        Self { slow: AccelerationMagnitude::of(2.3), fast: AccelerationMagnitude::of(2.0) }
    }
}

impl CurveSpeed {
    /// True if all keys have their defaults.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}
