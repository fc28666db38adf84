//! The header that every message starts with.

use crate::e2e::profile7::Protection;
use crate::layout::declare::*;
use serde::{Deserialize, Serialize};

layout! {
    /// Stamps of one input sample that a message was computed from.
    ///
    /// All stamps are run time: nanoseconds since the group's common start instant, the same in every
    /// process. An input that was not there has `sequence` 0 and stamps of −1.
    #[derive(Eq, Hash, Serialize, Deserialize)]
    pub struct Origin "timegap_msgs/msg/Origin" {
        /// Sequence number of the sample, counted from 1.
        pub sequence: u64,
        /// Time when the world was as the sample says, ns of run time.
        pub acquisition_ns: i64,
        /// Time when the sample was published, ns of run time.
        pub publish_ns: i64,
    }
}

impl Origin {
    /// The origin of an input that was not there.
    pub const NONE: Self = Self { sequence: 0, acquisition_ns: -1, publish_ns: -1 };

    /// The origin that a message with `header` is to those computed from it.
    pub fn of(header: &Header) -> Self {
        Self {
            sequence: header.sequence,
            acquisition_ns: header.acquisition_ns,
            publish_ns: header.publish_ns,
        }
    }

    /// True if `sample` is the one meant here. With `rides` it is a message that the same sender sent in the same step.
    /// Its topic rides with the sample's ([`Topic::rides_with`](crate::Topic::rides_with)). The two differ in the time
    /// of publication.
    pub fn means(&self, sample: &Self, rides: bool) -> bool {
        let same_step =
            (sample.sequence, sample.acquisition_ns) == (self.sequence, self.acquisition_ns);
        same_step && (rides || sample.publish_ns == self.publish_ns)
    }

    /// True if there was such an input.
    pub fn is_some(&self) -> bool {
        self.sequence != 0
    }
}

layout! {
    /// Stamps of the inputs of a message, one place per sensor topic. So a command alone shows its whole
    /// cause-effect chain.
    #[derive(Eq)]
    pub struct Origins "timegap_msgs/msg/Origins" {
        /// The `vehicle/odometry` sample.
        pub odometry: Origin,
        /// The `radar/tracks` sample.
        pub radar: Origin,
        /// The `v2x/spat` sample; in what the on-board unit says, the `radio/frames` batch.
        pub spat: Origin,
        /// The `v2x/map` sample.
        pub map: Origin,
        /// The `vehicle/powertrain` sample.
        pub powertrain: Origin,
        /// The `v2x/preview` sample.
        pub preview: Origin,
    }
}

impl Origins {
    /// No inputs, as in a message that starts a chain.
    pub const NONE: Self = Self {
        odometry: Origin::NONE,
        radar: Origin::NONE,
        spat: Origin::NONE,
        map: Origin::NONE,
        powertrain: Origin::NONE,
        preview: Origin::NONE,
    };
}

layout! {
    /// Beginning of every message.
    #[derive(Eq)]
    pub struct Header "timegap_msgs/msg/Header" {
        /// End-to-end protection of the message.
        pub protection: Protection,
        /// Number of this message on its topic from its source, counted from 1 in each incarnation.
        pub sequence: u64,
        /// Simulation step that the message belongs to.
        pub step: u64,
        /// Instant of the world in the message, ns of run time. It is the scheduled instant of the source's release, so
        /// that a source that stalls ages its own data.
        pub acquisition_ns: i64,
        /// Time when the message was handed to the transport, ns of run time.
        pub publish_ns: i64,
        /// Number of the source's restart that sent it: 0 for the first process.
        pub incarnation: u32,
        /// Service that sent it, `Service` as a number.
        pub source: u32,
        /// Stamps of the inputs it was computed from.
        pub origins: Origins,
    }
}

impl Header {
    /// A header to be filled in by the publisher, for a message of `step` made from `origins`.
    pub fn new(step: u64, acquisition_ns: i64, origins: Origins) -> Self {
        Self { step, acquisition_ns, origins, ..Self::zeroed() }
    }
}
