//! Mechanisms and conditions of a measurement.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Scheduling of the measured processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheduling {
    /// `SCHED_FIFO`, priorities as in a group.
    Fifo,
    /// The time-sharing default.
    Other,
}

/// Cores of the measured processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// All on the last usable core.
    SameCore,
    /// The source on the first usable core, the sink (in a group: the controller) on the last.
    TwoCores,
}

/// Load of the machine during a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// No load of ours.
    Idle,
    /// A computing process on every core.
    Cpu,
    /// A memory-copying process on every core.
    Memory,
}

macro_rules! names {
    ($($type:ident { $($variant:ident: $name:literal),+ })+) => {$(
        impl $type {
            /// Name in tables, results and tags.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    )+};
}

names! {
    Scheduling { Fifo: "fifo", Other: "other" }
    Placement { SameCore: "same_core", TwoCores: "two_cores" }
    Load { Idle: "idle", Cpu: "cpu", Memory: "memory" }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Conditions {
    pub placement: Placement,
    pub scheduling: Scheduling,
    pub load: Load,
}

impl Conditions {
    pub fn in_words(&self) -> String {
        let Self { placement, scheduling, load } = self;
        format!("{} {} {}", scheduling.name(), placement.name(), load.name())
    }

    /// Words in the tag of a histogram.
    pub fn tag(&self, period_us: u32) -> String {
        format!("{}:{period_us}us", self.in_words().replace(' ', ":"))
    }
}

/// Mechanism of a wake-up, with its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mechanism {
    /// A word in shared memory without data: the floor.
    Futex,
    /// A counter in the kernel.
    Eventfd,
    /// iceoryx2's event service.
    Iceoryx2Event,
    /// A message through the services' own ports: the radar's tracks.
    Message,
    /// The largest message through the services' own ports: the radar's detections.
    Detections,
    /// A payload, loaned and borrowed; a protected one is also written and checked in place.
    Payload { bytes: usize, is_protected: bool },
}

impl Mechanism {
    /// A payload that neither end reads or writes.
    pub const fn bare(bytes: usize) -> Self {
        Self::Payload { bytes, is_protected: false }
    }

    /// Name in tables and tags.
    pub fn name(self) -> String {
        match self {
            Self::Futex => "futex".into(),
            Self::Eventfd => "eventfd".into(),
            Self::Iceoryx2Event => "iceoryx2-event".into(),
            Self::Message => "message".into(),
            Self::Detections => "detections".into(),
            Self::Payload { bytes, is_protected: false } => format!("payload-{bytes}"),
            Self::Payload { bytes, .. } => format!("protected-payload-{bytes}"),
        }
    }
}

/// Size from which on a hand-over takes constant time, bytes: larger ones are not copied.
pub const FLAT_FROM: usize = 4 << 10;
/// Size of the largest payload, bytes.
pub const LARGEST: usize = 4 << 20;
