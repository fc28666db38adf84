//! State of the vehicle.

use crate::PhaseState;
use crate::layout::declare::*;

layout! {
    /// Motion of the ego vehicle, from the plant.
    pub message Odometry "timegap_msgs/msg/Odometry" {
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

macro_rules! moves {
    ($($motion:ty)+) => {$(
        impl $motion {
            /// Position in m and speed in m/s at `time_s`, if the acceleration stayed as it was since the
            /// sample. Braking ends at standstill.
            pub fn moved_to(&self, time_s: f64) -> (f64, f64) {
                let age_s = (time_s - self.header.acquisition_ns as f64 / 1e9).max(0.0);
                let (v, a) = (self.speed_mps, self.acceleration_mps2);
                let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
                (self.position_m + v * moving_s + 0.5 * a * moving_s * moving_s, v + a * moving_s)
            }
        }
    )+};
}
moves! { Odometry EgoTruth }

layout! {
    /// The ego as it really is, and what it meets.
    ///
    /// The simulated sensors measure from here, so that a fault of `vehicle/odometry` does not move the world. The
    /// launcher judges by it. Faults that wait for a phase of the drive begin by it.
    pub message EgoTruth "timegap_msgs/msg/EgoTruth" {
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
    /// Distance to the next stop line if its signal shows red, m, else infinite.
    pub fn red_line_m(&self) -> f64 {
        let is_red = self.signal_state == PhaseState::StopAndRemain.to_wire();
        if is_red { self.stop_line_m } else { f64::INFINITY }
    }
}

layout! {
    /// State of engine and gearbox, from a plant that has them.
    pub message Powertrain "timegap_msgs/msg/Powertrain" {
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
