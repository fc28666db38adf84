//! Constant speed: PI control of torque, with the resistance of the road under the truck fed forward.

use truck_model::Truck;

/// Proportional gain of the generic engine, N m per m/s.
const PROPORTIONAL: f64 = 1500.0;
/// Integral gain, N m per m.
const INTEGRAL: f64 = 40.0;

/// Keeps a speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedKeeper {
    integral_nm: f64,
}

impl SpeedKeeper {
    /// Engine torque between drag and full load, N m, for the next `dt_s`.
    pub fn torque_nm(
        &mut self,
        truck: &Truck,
        (set_mps, speed_mps): (f64, f64),
        gear: usize,
        grade: f64,
        dt_s: f64,
    ) -> f64 {
        let rpm = truck.engine_rpm(speed_mps, gear);
        let (low_nm, high_nm) =
            (truck.engine().drag_torque_nm(rpm), truck.engine().max_torque_nm(rpm));
        let scale = truck.parameters().engine_scale;
        let error_mps = set_mps - speed_mps;
        let hold_nm = truck.engine_torque_nm(0.0, speed_mps, gear, grade);
        let torque_nm = hold_nm + scale * PROPORTIONAL * error_mps + self.integral_nm;
        if (low_nm..high_nm).contains(&torque_nm) {
            self.integral_nm += scale * INTEGRAL * error_mps * dt_s;
        }
        torque_nm.clamp(low_nm, high_nm)
    }
}
