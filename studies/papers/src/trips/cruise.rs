//! Constant speed: the PI cruise control that savings are counted from.

use super::{CONTROL_PERIOD_S, Driver, Seen};
use controller::laws::truck::limiter;
use controller::laws::truck::speed_keeper::SpeedKeeper;
use truck_model::{Demand, Truck};

/// PI cruise at constant speed; it brakes above its limit only.
#[derive(Clone, Debug)]
pub struct Cruise {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    keeper: SpeedKeeper,
}

impl Cruise {
    /// A cruise control with a set speed and a limit.
    pub fn new(truck: &Truck, set_speed_mps: f64, limit_mps: f64) -> Self {
        Self { truck: *truck, set_speed_mps, limit_mps, keeper: SpeedKeeper::default() }
    }
}

impl Driver for Cruise {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let (speed_mps, gear) = (seen.motion.speed_mps, seen.motion.gear);
        let speeds_mps = (self.set_speed_mps, speed_mps);
        let torque_nm =
            self.keeper.torque_nm(&self.truck, speeds_mps, gear, seen.grade, CONTROL_PERIOD_S);
        let demand = Demand::torque(torque_nm);
        limiter::limited(&self.truck, demand, speed_mps, gear, seen.grade, self.limit_mps)
    }
}
