//! Payloads of any size beside the typed messages, for benchmarks.

use iceoryx2::prelude::ZeroCopySend;
use messages::Topic;
use std::mem::MaybeUninit;

/// Topic whose name and wake-up word the probe's payloads use.
pub(crate) const PAYLOAD_TOPIC: Topic = Topic::RadarTracks;

/// When a payload was sent, `CLOCK_MONOTONIC` ns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Stamp")]
pub(crate) struct Stamp {
    pub(crate) sent_ns: i64,
}

/// Payload bytes: they are never read, so that they need not be written.
pub(crate) type Payload = [MaybeUninit<u8>];
