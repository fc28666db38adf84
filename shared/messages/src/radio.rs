//! Frames on air, as bytes: what the on-board unit's radio hands out and takes.

use crate::layout::declare::*;

/// Longest frame, bytes, without the header of the link.
pub const MAX_FRAME_BYTES: usize = 1500;
/// Most frames in one batch.
pub const MAX_FRAMES: usize = 16;

layout! {
    /// A frame: GeoNetworking, BTP and the message in unaligned PER.
    pub struct RadioFrame "timegap_msgs/msg/RadioFrame" {
        /// Time when it was sent, by the sender's own account, ns of run time; the smallest number: not known.
        pub sent_ns: i64,
        /// Time when it arrived at the vehicle's radio, ns of run time.
        pub received_ns: i64,
        /// Valid bytes.
        pub length: u32,
        /// The bytes; unused ones are 0.
        pub bytes: [u8; MAX_FRAME_BYTES],
    }
}

impl RadioFrame {
    /// `sent_ns` of a frame that does not say when it was sent, or by a clock that is not known.
    pub const UNKNOWN_NS: i64 = i64::MIN;

    /// Time from sending to arrival, ns; `None` where it is not known.
    pub fn on_the_way_ns(&self) -> Option<i64> {
        (self.sent_ns != Self::UNKNOWN_NS).then(|| self.received_ns.saturating_sub(self.sent_ns))
    }

    pub fn data(&self) -> &[u8] {
        &self.bytes[..(self.length as usize).min(MAX_FRAME_BYTES)]
    }

    /// Writes a frame; of one that is too long, what there is room for.
    pub fn write(&mut self, sent_ns: i64, received_ns: i64, data: &[u8]) {
        let data = &data[..data.len().min(MAX_FRAME_BYTES)];
        (self.sent_ns, self.received_ns) = (sent_ns, received_ns);
        self.length = data.len() as u32;
        self.bytes[..data.len()].copy_from_slice(data);
        self.bytes[data.len()..].fill(0);
    }
}

layout! {
    /// The frames that arrived since the last batch.
    pub message RadioFrames "timegap_msgs/msg/RadioFrames" lists frames: RadioFrame {
        /// UTC of run time 0 by the clock of the vehicle's radio, ns since 1970.
        pub utc_start_ns: i64,
        /// Time by which the sender's clock is ahead of the vehicle's, as two hosts compared them, ns.
        pub clock_offset_ns: i64,
        /// Largest error of that, ns; 0 if both are one clock. The largest number: not known.
        pub clock_uncertainty_ns: i64,
        /// Frames that arrived and for which there was no room.
        pub left_out: u64,
        /// Valid entries of `frames`.
        pub count: u64,
        /// The frames in the order of their arrival; unused entries are 0.
        pub frames: [RadioFrame; MAX_FRAMES],
    }

    /// A frame that the vehicle sends.
    pub message RadioSent "timegap_msgs/msg/RadioSent" {
        /// UTC of run time 0 by the vehicle's clock, ns since 1970.
        pub utc_start_ns: i64,
        /// The frame; `received_ns` is -1.
        pub frame: RadioFrame,
    }
}
