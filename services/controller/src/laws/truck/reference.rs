//! The truck that keeps its speed: the time that a road takes without a plan.
//!
//! It drives over the same metres as the real truck. It keeps its set speed if engine and drag can hold it. Uphill it
//! is slower at full load, and downhill it goes up to the limit. It is always in its strongest gear and never shifts.
//! On a long climb of 3 % that makes it up to 8 % faster than the plant's truck.

use truck_model::{GEARS, Truck};

/// Slowest speed, m/s: starting is not part of a cruise.
const SLOWEST_MPS: f64 = 3.0;
/// Longest step, m: over it forces are constant.
const STEP_M: f64 = 5.0;

/// Speeds of the reference, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// That it keeps.
    pub set_mps: f64,
    /// At which it brakes.
    pub limit_mps: f64,
    /// With which it starts: the real truck's.
    pub start_mps: f64,
}

/// The truck, driven in distance.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    speed_mps: Option<f64>,
}

impl Reference {
    /// Drives on for `distance_m` of one grade; the time that it takes, s.
    pub fn advance(&mut self, truck: &Truck, distance_m: f64, grade: f64, speeds: &Speeds) -> f64 {
        let mut speed_mps = self.speed_mps.unwrap_or(speeds.start_mps).max(SLOWEST_MPS);
        let mut time_s = 0.0;
        let steps = (distance_m / STEP_M).ceil().max(1.0);
        let step_m = distance_m / steps;
        for _ in 0..steps as u32 {
            let (low_n, high_n) = forces_n(truck, speed_mps);
            let energy_j = truck.kinetic_energy_j(speed_mps);
            let resistance_n = truck.resistance_n(speed_mps, grade);
            let after =
                |force_n: f64| truck.speed_mps(energy_j + step_m * (force_n - resistance_n));
            let kept_mps = speeds.set_mps.max(after(low_n)).min(after(high_n));
            let end_mps = kept_mps.min(speeds.limit_mps).max(SLOWEST_MPS);
            time_s += 2.0 * step_m / (speed_mps + end_mps);
            speed_mps = end_mps;
        }
        self.speed_mps = Some(speed_mps);
        time_s
    }
}

/// Tractive force with the injection cut, in the highest gear that turns the engine, N. The second is the
/// most that any gear gives.
fn forces_n(truck: &Truck, speed_mps: f64) -> (f64, f64) {
    let gears = (0..GEARS).filter(|&gear| truck.gear_allowed(speed_mps, gear));
    gears.fold((0.0, 0.0), |(_, most_n): (f64, f64), gear| {
        let (drag_nm, full_nm) = truck.net_torque_limits_nm(speed_mps, gear);
        (truck.force_n(drag_nm, gear), most_n.max(truck.force_n(full_nm, gear)))
    })
}
