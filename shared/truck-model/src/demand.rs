//! Request to a truck, and the inner loop that derives it from an acceleration.

use crate::engine::IDLE_RPM;
use crate::parameters::GEARS;
use crate::truck::Truck;

/// Request to engine, brakes and gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Torque at the crankshaft \[N m\]. The injection gives torques between drag and full load;
    /// the engine brake gives torques below drag. The engine's limits apply.
    pub engine_torque_nm: f64,
    /// Force of the service brakes at the wheels \[N\], 0 or more.
    pub service_brake_n: f64,
    /// Gear to engage, counted from 0. It is engaged when the engine can run in it and enough time
    /// has passed since the last shift. `None` leaves the choice to the gearbox's rule.
    pub gear: Option<usize>,
}

impl Demand {
    /// Returns a demand for engine torque alone.
    pub fn torque(engine_torque_nm: f64) -> Self {
        Self { engine_torque_nm, ..Self::default() }
    }

    /// Returns the demand for an acceleration: engine first, then engine brake, then service
    /// brakes.
    ///
    /// Below the speed of the idling engine the clutch is open to braking torques. The service
    /// brakes then take all of the braking.
    ///
    /// ```
    /// use truck_model::{Demand, Motion, Preset, Truck};
    ///
    /// let truck = Truck::preset(Preset::Jh6At49T);
    /// let motion = Motion::new(&truck, 0.0, 20.0, 0.0);
    /// let demand = Demand::for_acceleration(&truck, -0.1, motion.speed_mps, motion.gear, 0.0);
    /// assert!(demand.engine_torque_nm < 0.0, "the engine brake comes first");
    /// assert_eq!(demand.service_brake_n, 0.0);
    /// ```
    pub fn for_acceleration(
        truck: &Truck,
        acceleration_mps2: f64,
        speed_mps: f64,
        gear: usize,
        grade: f64,
    ) -> Self {
        let gear = gear.min(GEARS - 1);
        let wanted_nm = truck.engine_torque_nm(acceleration_mps2, speed_mps, gear, grade);
        let rpm = truck.engine_rpm(speed_mps, gear);
        let lowest_nm = if rpm < IDLE_RPM {
            truck.auxiliary_torque_nm(IDLE_RPM)
        } else {
            truck.engine().brake_torque_nm(rpm)
        };
        let service_brake_n = if wanted_nm < lowest_nm {
            (lowest_nm - wanted_nm) * truck.crank_radians_per_m(gear)
                / truck.parameters().driveline_efficiency
        } else {
            0.0
        };
        Self { engine_torque_nm: wanted_nm.max(lowest_nm), service_brake_n, gear: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Motion;
    use crate::parameters::Preset;

    /// From walking pace to 0.1 m/s: the clutch opens on the way.
    #[test]
    fn the_request_is_met_at_any_speed_and_on_any_grade() {
        for preset in Preset::ALL {
            let truck = Truck::preset(preset);
            for grade in [-0.1, -0.01, 0.0, 0.01, 0.03] {
                for speed_mps in [0.1, 0.3, 1.0, 3.0] {
                    let mut motion = Motion::new(&truck, 0.0, speed_mps, grade);
                    let gear = motion.gear;
                    let demand = Demand::for_acceleration(&truck, -0.5, speed_mps, gear, grade);
                    motion.engine_torque_nm = demand.engine_torque_nm;
                    motion.step(&truck, 0.01, &demand, grade);
                    // If the engine still has to push, it does so at once here.
                    let felt = motion.acceleration_mps2;
                    assert!((felt + 0.5).abs() < 2e-3, "{felt} m/s² at {speed_mps} m/s, {grade}");
                }
            }
        }
    }
}
