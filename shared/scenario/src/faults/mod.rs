//! `[[faults]]`: what goes wrong, when, and for how long.
//!
//! A fault of a process is carried out by the launcher, one of a channel between a message's arrival and
//! the receiver's check, one of a sender before the message is protected. `file` reads the table.

mod file;
mod kind;

pub use file::read;
pub(super) use file::{keys_of, take_from, written};
pub use kind::{Kind, UnknownKind};

use serde::{Deserialize, Serialize};

use super::quantity::{
    AccelerationMagnitude, Core, Count, DelayMs, Distance, Duration, Megabytes, Probability, Shift,
    Speed, Time,
};
use messages::{Drive, Service, Topic};

/// Most faults in one scenario.
pub const MAX_FAULTS: usize = 64;

/// A fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// When it begins.
    #[serde(flatten)]
    pub begin: Begin,
    /// What happens.
    #[serde(flatten)]
    pub effect: Effect,
}

/// When a fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Begin {
    /// At an instant.
    At {
        /// When it begins, s of run time.
        at_s: Time,
    },
    /// By what the ego does and meets.
    When {
        /// When it begins, by what the ego does and meets; all conditions that are given must hold at
        /// once.
        when: Condition,
    },
}

impl Begin {
    /// Run time at which it begins, ns, where that is known beforehand.
    #[must_use]
    pub fn known_ns(&self) -> Option<i64> {
        match self {
            Self::At { at_s } => Some(i64::try_from(at_s.nanoseconds()).unwrap_or(i64::MAX)),
            Self::When { .. } => None,
        }
    }

    /// True if it begins with the ego driving so.
    #[must_use]
    pub fn is_met(&self, drive: &Drive) -> bool {
        match self {
            Self::At { .. } => false,
            Self::When { when } => when.holds(drive),
        }
    }
}

/// What must be so for a fault to begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The ego is beyond this place, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_above_m: Option<Distance>,
    /// The ego is slower, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_below_mps: Option<Speed>,
    /// The ego is faster, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_above_mps: Option<Speed>,
    /// The ego brakes harder, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub braking_above_mps2: Option<AccelerationMagnitude>,
    /// The time to collision with the vehicle ahead is shorter, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ttc_below_s: Option<Time>,
    /// The next stop line is nearer, and its signal shows red, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub red_line_below_m: Option<Distance>,
    /// A vehicle ahead moves sideways towards the ego's lane, or none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut_in: Option<bool>,
    /// The ego stands, or it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standstill: Option<bool>,
}

/// Below this speed the ego stands, m/s.
pub const STANDSTILL_MPS: f64 = 0.1;

impl Condition {
    /// True if it holds for an ego that drives so.
    #[must_use]
    pub fn holds(&self, drive: &Drive) -> bool {
        let stands = drive.speed_mps < STANDSTILL_MPS;
        let deceleration_mps2 = -drive.acceleration_mps2;
        self.position_above_m.is_none_or(|limit| drive.position_m > limit.value())
            && self.speed_below_mps.is_none_or(|limit| drive.speed_mps < limit.value())
            && self.speed_above_mps.is_none_or(|limit| drive.speed_mps > limit.value())
            && self.braking_above_mps2.is_none_or(|limit| deceleration_mps2 > limit.value())
            && self.ttc_below_s.is_none_or(|limit| drive.time_to_collision_s < limit.value())
            && self.red_line_below_m.is_none_or(|limit| drive.red_line_m < limit.value())
            && self.cut_in.is_none_or(|wanted| drive.cut_in == wanted)
            && self.standstill.is_none_or(|wanted| stands == wanted)
    }
}

/// What happens.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Effect {
    /// To processes, by the launcher's hand.
    Process(ProcessFault),
    /// To messages between their sender and a receiver.
    Channel(ChannelFault),
    /// To messages in their sender.
    Sender(SenderFault),
}

/// A fault of processes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProcessFault {
    /// The service's process is killed (SIGKILL).
    Kill {
        /// The service that it acts on.
        service: Service,
    },
    /// The service's process is stopped (SIGSTOP), and continued after `for_s`.
    Stop {
        /// The service that it acts on.
        service: Service,
        /// How long it lasts, s; absent: to the end of the run.
        #[serde(skip_serializing_if = "Option::is_none")]
        for_s: Option<Duration>,
    },
    /// The service's process is killed again and again, as soon as it is back.
    RestartStorm {
        /// The service that it acts on.
        service: Service,
        /// How often the service is killed.
        times: Count,
        /// So long after its start each process after the first is killed, ms: while it starts; absent: as
        /// soon as it takes part.
        #[serde(skip_serializing_if = "Option::is_none")]
        after_start_ms: Option<DelayMs>,
    },
    /// A process of the run that is no service is killed (SIGKILL).
    KillHelper {
        /// The process that is killed; the recorder only where the run is recorded.
        helper: Helper,
    },
    /// Processes of no service keep the processor busy.
    Hog {
        /// The core that is kept busy; absent: all.
        #[serde(skip_serializing_if = "Option::is_none")]
        core: Option<Core>,
        /// How long it lasts, s; absent: to the end of the run.
        #[serde(skip_serializing_if = "Option::is_none")]
        for_s: Option<Duration>,
    },
    /// A process of no service takes memory.
    Memory {
        /// Memory that is taken and touched, MiB.
        megabytes: Megabytes,
        /// How long it lasts, s; absent: to the end of the run.
        #[serde(skip_serializing_if = "Option::is_none")]
        for_s: Option<Duration>,
    },
}

/// A fault of the channel between a topic and its receivers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelFault {
    /// What happens to a message.
    #[serde(flatten)]
    pub disturbance: Disturbance,
    /// The topic whose messages it acts on.
    pub topic: TopicName,
    /// Which messages.
    #[serde(flatten)]
    pub extent: Extent,
}

/// What happens to a message on its way.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Disturbance {
    /// It arrives late.
    Delay {
        /// By how much a message is late, ms.
        delay_ms: DelayMs,
        /// On top of that, up to so much more, ms, anew for each message.
        jitter_ms: DelayMs,
    },
    /// It does not arrive.
    Drop,
    /// It arrives twice.
    Duplicate,
    /// It arrives after its successor.
    Reorder,
    /// Bits of it are flipped.
    Corrupt {
        /// Bits flipped in a message.
        bits: Count,
    },
}

/// A fault of a sender: messages that are intact and whose content is false.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SenderFault {
    /// What is false.
    #[serde(flatten)]
    pub falsification: Falsification,
    /// Which messages.
    #[serde(flatten)]
    pub extent: Extent,
}

/// What is false in a message.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Falsification {
    /// The content of the last message is repeated under fresh stamps.
    Freeze {
        /// The topic whose messages it acts on.
        topic: TopicName,
    },
    /// A figure is off.
    Bias {
        /// The figure that is off.
        #[serde(flatten, serialize_with = "file::with_topic")]
        field: BiasedField,
        /// By how much the figure is off, in its unit.
        amount: Shift,
    },
    /// The acquisition stamps are old.
    Stale {
        /// The topic whose messages it acts on.
        topic: TopicName,
        /// By how much the stamps are old, s.
        amount: Shift,
    },
    /// The service's clock is off: all its stamps are.
    ClockStep {
        /// The service that it acts on.
        service: Service,
        /// By how much the clock is ahead, s.
        amount: Shift,
    },
}

/// Which messages a fault acts on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extent {
    /// Part of the messages that it acts on.
    pub probability: Probability,
    /// How long it lasts, s; absent: to the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<Duration>,
}

/// A process of a run that is no service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Helper {
    /// Writes the recording.
    Recorder,
    /// Cleans up after a launcher that was killed.
    Janitor,
    /// Starts and supervises all others.
    Launcher,
}

impl Helper {
    /// Name in files and in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Recorder => "recorder",
            Self::Janitor => "janitor",
            Self::Launcher => "launcher",
        }
    }
}

/// What a fault acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A service: its process, or all its messages.
    Service(Service),
    /// A process that is no service.
    Helper(Helper),
    /// A topic's messages.
    Topic(Topic),
    /// The machine.
    Machine,
}

impl Effect {
    /// What it acts on.
    #[must_use]
    pub const fn target(&self) -> Target {
        match self {
            Self::Process(
                ProcessFault::Kill { service }
                | ProcessFault::Stop { service, .. }
                | ProcessFault::RestartStorm { service, .. },
            ) => Target::Service(*service),
            Self::Process(ProcessFault::KillHelper { helper }) => Target::Helper(*helper),
            Self::Process(ProcessFault::Hog { .. } | ProcessFault::Memory { .. }) => {
                Target::Machine
            }
            Self::Channel(fault) => Target::Topic(fault.topic.0),
            Self::Sender(SenderFault { falsification, .. }) => match falsification {
                Falsification::Freeze { topic } | Falsification::Stale { topic, .. } => {
                    Target::Topic(topic.0)
                }
                Falsification::Bias { field, .. } => Target::Topic(field.topic()),
                Falsification::ClockStep { service, .. } => Target::Service(*service),
            },
        }
    }

    /// Which messages it acts on, if it acts on messages.
    #[must_use]
    pub const fn extent(&self) -> Option<Extent> {
        match self {
            Self::Process(_) => None,
            Self::Channel(ChannelFault { extent, .. })
            | Self::Sender(SenderFault { extent, .. }) => Some(*extent),
        }
    }

    /// How long it lasts; none for what lasts to the end of the run or is over at once.
    #[must_use]
    pub const fn length(&self) -> Option<Duration> {
        match self {
            Self::Process(
                ProcessFault::Kill { .. }
                | ProcessFault::RestartStorm { .. }
                | ProcessFault::KillHelper { .. },
            ) => None,
            Self::Process(
                ProcessFault::Stop { for_s, .. }
                | ProcessFault::Hog { for_s, .. }
                | ProcessFault::Memory { for_s, .. },
            ) => *for_s,
            Self::Channel(ChannelFault { extent, .. })
            | Self::Sender(SenderFault { extent, .. }) => extent.for_s,
        }
    }

    /// Run time after which it is over once it began at `begun_ns`, ns.
    #[must_use]
    pub fn end_ns(&self, begun_ns: i64) -> i64 {
        let length = self.length();
        length.map_or(i64::MAX, |length| begun_ns.saturating_add_unsigned(length.nanoseconds()))
    }

    /// The fault of processes that it is, if it is one.
    #[must_use]
    pub const fn of_processes(&self) -> Option<&ProcessFault> {
        match self {
            Self::Process(fault) => Some(fault),
            Self::Channel(_) | Self::Sender(_) => None,
        }
    }

    /// The fault of a channel that it is, if it is one.
    #[must_use]
    pub const fn of_channels(&self) -> Option<&ChannelFault> {
        match self {
            Self::Channel(fault) => Some(fault),
            Self::Process(_) | Self::Sender(_) => None,
        }
    }

    /// The fault of a sender that it is, if it is one.
    #[must_use]
    pub const fn of_senders(&self) -> Option<&SenderFault> {
        match self {
            Self::Sender(fault) => Some(fault),
            Self::Process(_) | Self::Channel(_) => None,
        }
    }
}

/// A figure that a `bias` can falsify.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasedField {
    /// `radar/tracks`: gap to the target, m.
    GapM,
    /// `radar/tracks`: relative speed of the target, m/s.
    RelativeSpeedMps,
    /// `vehicle/odometry`: speed, m/s.
    SpeedMps,
    /// `v2x/spat`: all ends of intervals, s.
    EndS,
}

impl BiasedField {
    /// The topic that carries it.
    #[must_use]
    pub const fn topic(self) -> Topic {
        match self {
            Self::GapM | Self::RelativeSpeedMps => Topic::RadarTracks,
            Self::SpeedMps => Topic::Odometry,
            Self::EndS => Topic::Spat,
        }
    }
}

/// A topic by its name, one whose messages can be disturbed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct TopicName(pub Topic);

impl TopicName {
    /// Topics whose messages can be disturbed.
    pub const ALL: [Topic; 6] = [
        Topic::Odometry,
        Topic::RadarTracks,
        Topic::RadioFrames,
        Topic::Spat,
        Topic::Map,
        Topic::Command,
    ];
}

/// A name of no topic whose messages can be disturbed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no messages of `{0}` can be disturbed, expected one of {names}",
    names = TopicName::ALL.map(Topic::name).join(", ")
)]
pub struct NoSuchTopic(String);

impl TryFrom<String> for TopicName {
    type Error = NoSuchTopic;

    fn try_from(name: String) -> Result<Self, NoSuchTopic> {
        let found = Self::ALL.into_iter().find(|topic| topic.name() == name);
        found.map(Self).ok_or(NoSuchTopic(name))
    }
}

impl From<TopicName> for String {
    fn from(name: TopicName) -> Self {
        name.0.name().into()
    }
}
