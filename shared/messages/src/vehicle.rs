//! What the vehicle says of itself.

use super::{Header, Topic, layout, message};
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Motion of the ego vehicle, from the plant.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
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

message!(
    Odometry,
    Topic::Odometry,
    fn ego(&self) -> Option<(f64, f64)> {
        Some((self.position_m, self.speed_mps))
    }
);
layout!(Odometry { header, position_m, speed_mps, acceleration_mps2, request_mps2 });

impl Odometry {
    /// Position in m and speed in m/s at `time_s`, if the acceleration stayed as it was since the
    /// sample. Braking ends at standstill.
    #[must_use]
    pub fn moved_to(&self, time_s: f64) -> (f64, f64) {
        let age_s = (time_s - self.header.acquisition_ns as f64 / 1e9).max(0.0);
        let (v, a) = (self.speed_mps, self.acceleration_mps2);
        let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
        (self.position_m + v * moving_s + 0.5 * a * moving_s * moving_s, v + a * moving_s)
    }
}

/// What engine and gearbox do, from a plant that has them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
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
    /// What an accelerometer along the vehicle's axis shows: the acceleration and the slope's share of
    /// gravity, m/s².
    pub specific_force_mps2: f64,
}

message!(Powertrain, Topic::Powertrain);
layout!(Powertrain {
    header,
    gear,
    shifts,
    since_shift_s,
    engine_speed_rpm,
    engine_torque_nm,
    service_brake_n,
    fuel_gps,
    fuel_g,
    specific_force_mps2,
});
