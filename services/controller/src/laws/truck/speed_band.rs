//! The speeds that a plan may have, around the driver's set speed (step 3).

use super::settings::BoundKeys;
use crate::law::PlanRequest;

/// Lowest and highest speed of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedBand {
    /// Lowest speed where the truck can hold it, m/s: 13 km/h below the set speed, if nothing else is set.
    pub min_mps: f64,
    /// Highest speed, m/s: 5 km/h above the set speed, if nothing else is set, and within the limit.
    pub max_mps: f64,
}

impl SpeedBand {
    /// The band of a request.
    #[must_use]
    pub fn of(keys: &BoundKeys, request: &PlanRequest) -> Self {
        let max_mps = max_speed_mps(keys, request.set_speed_mps, request.speed_limit_mps);
        Self { min_mps: min_speed_mps(keys, request.set_speed_mps).min(max_mps), max_mps }
    }
}

/// Highest speed that is planned, m/s.
pub fn max_speed_mps(keys: &BoundKeys, set_speed_mps: f64, speed_limit_mps: f64) -> f64 {
    (set_speed_mps + keys.above_set_kmh / 3.6).min(speed_limit_mps)
}

/// Lowest speed that is planned where the truck can hold it, m/s.
pub fn min_speed_mps(keys: &BoundKeys, set_speed_mps: f64) -> f64 {
    set_speed_mps - keys.below_set_kmh / 3.6
}
