//! What a truck can be asked for, and the inner loop that turns an acceleration into it.

use crate::parameters::GEARS;
use crate::truck::Truck;

/// A request to engine, brakes and gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Torque at the crankshaft, N m. Between drag and full load it is the injection's; below drag it
    /// is the engine brake's. What the engine cannot give is not given.
    pub engine_torque_nm: f64,
    /// Force of the service brakes at the wheels, N, 0 or more.
    pub service_brake_n: f64,
    /// A gear to engage, counted from 0, when the engine can turn in it and the last shift is over
    /// for long enough; `None` leaves it to the gearbox's own rule.
    pub gear: Option<usize>,
}

impl Demand {
    /// Engine torque alone.
    #[must_use]
    pub fn torque(engine_torque_nm: f64) -> Self {
        Self { engine_torque_nm, ..Self::default() }
    }

    /// The demand that gives an acceleration: engine first, then engine brake, then service brakes.
    #[must_use]
    pub fn for_acceleration(
        truck: &Truck,
        acceleration_mps2: f64,
        speed_mps: f64,
        gear: usize,
        grade: f64,
    ) -> Self {
        let gear = gear.min(GEARS - 1);
        let wanted_nm = truck.engine_torque_nm(acceleration_mps2, speed_mps, gear, grade);
        let lowest_nm = truck.engine().brake_torque_nm(truck.engine_rpm(speed_mps, gear));
        let service_brake_n = if wanted_nm < lowest_nm {
            (lowest_nm - wanted_nm) * truck.crank_radians_per_m(gear)
                / truck.parameters().driveline_efficiency
        } else {
            0.0
        };
        Self { engine_torque_nm: wanted_nm.max(lowest_nm), service_brake_n, gear: None }
    }
}
