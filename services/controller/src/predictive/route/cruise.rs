//! Constant speed: the PI cruise control that savings are counted from.

use super::{CONTROL_PERIOD_S, Driver, Seen};
use crate::predictive::limiter;
use truck_model::{Demand, Truck};

/// Proportional gain, N m per m/s at 49 t.
const PROPORTIONAL: f64 = 1500.0;
/// Integral gain, N m per m at 49 t.
const INTEGRAL: f64 = 40.0;

/// PI cruise at constant speed, with the resistance of the road under the truck fed forward.
#[derive(Clone, Debug)]
pub struct Cruise {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    integral_nm: f64,
}

impl Cruise {
    /// A cruise control that brakes above `limit_mps` only.
    #[must_use]
    pub fn new(truck: &Truck, set_speed_mps: f64, limit_mps: f64) -> Self {
        Self { truck: *truck, set_speed_mps, limit_mps, integral_nm: 0.0 }
    }
}

impl Driver for Cruise {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let motion = seen.motion;
        let rpm = self.truck.engine_rpm(motion.speed_mps, motion.gear);
        let (low_nm, high_nm) =
            (self.truck.engine().drag_torque_nm(rpm), self.truck.engine().max_torque_nm(rpm));
        let error_mps = self.set_speed_mps - motion.speed_mps;
        let hold_nm = self.truck.engine_torque_nm(0.0, motion.speed_mps, motion.gear, seen.grade);
        let torque_nm = hold_nm + PROPORTIONAL * error_mps + self.integral_nm;
        if (low_nm..high_nm).contains(&torque_nm) {
            self.integral_nm += INTEGRAL * error_mps * CONTROL_PERIOD_S;
        }
        let demand = Demand::torque(torque_nm.clamp(low_nm, high_nm));
        limiter::limited(
            &self.truck,
            demand,
            motion.speed_mps,
            motion.gear,
            seen.grade,
            self.limit_mps,
        )
    }
}
