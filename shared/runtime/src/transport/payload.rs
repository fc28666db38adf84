//! Payloads of any size beside the typed messages, for benchmarks.

use iceoryx2::prelude::ZeroCopySend;
use messages::Topic;

/// Topic whose wake-up word the probe's payloads use.
pub(crate) const PAYLOAD_TOPIC: Topic = Topic::RadarTracks;

/// When a payload was sent, `CLOCK_MONOTONIC` ns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Stamp")]
pub(crate) struct Stamp {
    pub(crate) sent_ns: i64,
}

/// Payload bytes.
pub(crate) type Payload = [u8];
