//! The downhill speed limiter: engine brake, then service brakes, when a truck runs away.

use truck_model::{Demand, Truck};

/// Deceleration per speed above the limit, 1/s.
const GAIN_PER_S: f64 = 0.5;
/// Distance below the limit at which it begins to act, m/s.
const MARGIN_MPS: f64 = 0.1;

/// `demand`, but no more than holds the truck at `limit_mps` once it is there.
#[must_use]
pub fn limited(
    truck: &Truck,
    demand: Demand,
    speed_mps: f64,
    gear: usize,
    grade: f64,
    limit_mps: f64,
) -> Demand {
    if speed_mps < limit_mps - MARGIN_MPS {
        return demand;
    }
    let acceleration_mps2 = GAIN_PER_S * (limit_mps - speed_mps);
    let holding = Demand::for_acceleration(truck, acceleration_mps2, speed_mps, gear, grade);
    Demand {
        engine_torque_nm: demand.engine_torque_nm.min(holding.engine_torque_nm),
        service_brake_n: demand.service_brake_n.max(holding.service_brake_n),
        gear: demand.gear,
    }
}
