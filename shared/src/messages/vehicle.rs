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

message!(Odometry, Topic::Odometry);
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
