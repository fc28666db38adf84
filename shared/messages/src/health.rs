//! Signs of life.

use crate::layout::declare::*;
use crate::numbered;

numbered! {
    /// Condition of a service, by its number in messages.
    pub enum ServiceState {
        /// In its loop, with all inputs.
        Running = 1 "running",
        /// In its loop; an input is missing or stale.
        Degraded = 2 "degraded",
    }
}

layout! {
    /// Periodic sign of life of a service.
    #[derive(Eq)]
    pub message Heartbeat "timegap_msgs/msg/Heartbeat" {
        /// Cycles done so far.
        pub cycles: u64,
        /// [`ServiceState`] as a number.
        pub state: u64,
    }
}
