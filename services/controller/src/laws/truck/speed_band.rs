//! The speeds that a plan may have, around the driver's set speed.

use crate::law::PlanRequest;

/// How far a plan may exceed the set speed, m/s.
const ABOVE_SET_MPS: f64 = 5.0 / 3.6;
/// How far it may fall below (62 km/h at a set speed of 75 km/h), m/s.
const BELOW_SET_MPS: f64 = 13.0 / 3.6;

/// Lowest and highest speed of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedBand {
    /// Lowest speed where the truck can hold it, m/s: 13 km/h below the set speed.
    pub min_mps: f64,
    /// Highest speed, m/s: 5 km/h above the set speed and within the limit.
    pub max_mps: f64,
}

impl SpeedBand {
    /// The band of a request.
    #[must_use]
    pub fn of(request: &PlanRequest) -> Self {
        let max_mps = max_speed_mps(request.set_speed_mps, request.speed_limit_mps);
        Self { min_mps: min_speed_mps(request.set_speed_mps).min(max_mps), max_mps }
    }
}

/// Highest speed that is planned, m/s.
pub(crate) fn max_speed_mps(set_speed_mps: f64, speed_limit_mps: f64) -> f64 {
    (set_speed_mps + ABOVE_SET_MPS).min(speed_limit_mps)
}

/// Lowest speed that is planned where the truck can hold it, m/s.
pub(crate) fn min_speed_mps(set_speed_mps: f64) -> f64 {
    set_speed_mps - BELOW_SET_MPS
}
