//! Signs of life.

use super::{Header, Topic, layout, message};
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// What a service says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceState {
    /// In its loop, all inputs there.
    Running = 1,
    /// In its loop, some input missing or stale.
    Degraded = 2,
}

/// Periodic sign of life of a service.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Heartbeat")]
pub struct Heartbeat {
    /// Common header; its source tells the service.
    pub header: Header,
    /// Cycles done so far.
    pub cycles: u64,
    /// [`ServiceState`] as a number.
    pub state: u64,
}

message!(Heartbeat, Topic::Heartbeat);
layout!(Heartbeat { header, cycles, state });
