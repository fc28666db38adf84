//! What the vehicle says of itself.

use super::{Header, Topic, message};
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
