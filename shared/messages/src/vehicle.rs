//! State of the vehicle.

use super::Header;
use crate::layout::declare::*;

layout! {
    /// Motion of the ego vehicle, from the plant.
    #[type_name("timegap_msgs/msg/Odometry")]
    pub struct Odometry {
        /// Common header.
        pub header: Header,
        /// Distance travelled by the front bumper since the start of the run, m.
        pub position_m: f64,
        /// Speed, m/s, never negative.
        pub speed_mps: f64,
        /// Acceleration, m/s².
        pub acceleration_mps2: f64,
        /// Request that the actuators follow, after the gateway's bounds, m/s².
        pub request_mps2: f64,
    }
}

impl Odometry {
    /// Position in m and speed in m/s at `time_s`, if the acceleration stayed as it was since the
    /// sample. Braking ends at standstill.
    pub fn moved_to(&self, time_s: f64) -> (f64, f64) {
        let age_s = (time_s - self.header.acquisition_ns as f64 / 1e9).max(0.0);
        moved(self.position_m, self.speed_mps, self.acceleration_mps2, age_s)
    }
}

/// Position and speed `age_s` later at constant acceleration; braking ends at standstill.
fn moved(position_m: f64, v: f64, a: f64, age_s: f64) -> (f64, f64) {
    let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
    (position_m + v * moving_s + 0.5 * a * moving_s * moving_s, v + a * moving_s)
}

layout! {
    /// The ego as it really is, and what it meets.
    ///
    /// The simulated sensors measure from here, so that a fault of `vehicle/odometry` does not move the world. The
    /// launcher judges by it. Faults that wait for a phase of the drive begin by it.
    #[type_name("timegap_msgs/msg/EgoTruth")]
    pub struct EgoTruth {
        /// Common header.
        pub header: Header,
        /// Distance travelled by the front bumper since the start of the run, m.
        pub position_m: f64,
        /// Speed, m/s, never negative.
        pub speed_mps: f64,
        /// Acceleration, m/s².
        pub acceleration_mps2: f64,
        /// Request that the actuators follow, after the gateway's bounds, m/s².
        pub request_mps2: f64,
        /// Time to collision with the vehicle ahead, s, infinite without one or when it does not come closer.
        pub time_to_collision_s: f64,
        /// Distance to the next stop line ahead, m, infinite without one.
        pub stop_line_m: f64,
        /// Phase of its signal, `PhaseState` as a number; 0 without a signal.
        pub signal_state: u32,
        /// 1 while a vehicle ahead moves sideways towards the ego's lane.
        pub cut_in: u32,
    }
}

impl EgoTruth {
    /// Position in m and speed in m/s at `time_s`, if the acceleration stayed as it was since the
    /// sample. Braking ends at standstill.
    pub fn moved_to(&self, time_s: f64) -> (f64, f64) {
        let age_s = (time_s - self.header.acquisition_ns as f64 / 1e9).max(0.0);
        moved(self.position_m, self.speed_mps, self.acceleration_mps2, age_s)
    }
}

/// Drive of the ego at one instant: faults can wait for a phase of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Position of the front bumper, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Time to collision with the vehicle ahead, s, or infinite.
    pub time_to_collision_s: f64,
    /// Distance to the next stop line if its signal shows red, m, else infinite.
    pub red_line_m: f64,
    /// A vehicle ahead moves sideways towards the ego's lane.
    pub cut_in: bool,
}

impl Drive {
    /// The phase by the ground truth.
    pub fn of(truth: &EgoTruth) -> Self {
        let red = truth.signal_state == crate::PhaseState::StopAndRemain.to_wire();
        Self {
            position_m: truth.position_m,
            speed_mps: truth.speed_mps,
            acceleration_mps2: truth.acceleration_mps2,
            time_to_collision_s: truth.time_to_collision_s,
            red_line_m: if red { truth.stop_line_m } else { f64::INFINITY },
            cut_in: truth.cut_in != 0,
        }
    }
}

layout! {
    /// State of engine and gearbox, from a plant that has them.
    #[type_name("timegap_msgs/msg/Powertrain")]
    pub struct Powertrain {
        /// Common header.
        pub header: Header,
        /// Gear, counted from 1, the lowest.
        pub gear: u32,
        /// Number of shifts since the start of the run.
        pub shifts: u32,
        /// Time since the last shift began, s.
        pub since_shift_s: f64,
        /// Engine speed, rpm.
        pub engine_speed_rpm: f64,
        /// Torque at the crankshaft, N m.
        pub engine_torque_nm: f64,
        /// Force of the service brakes at the wheels, N.
        pub service_brake_n: f64,
        /// Fuel flow, g/s.
        pub fuel_gps: f64,
        /// Fuel burnt since the start of the run, g.
        pub fuel_g: f64,
        /// Reading of an accelerometer along the vehicle's axis: the acceleration and the slope's share of gravity,
        /// m/s².
        pub specific_force_mps2: f64,
    }
}
