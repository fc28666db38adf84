//! What a fault does, each kind with the keys of its own.

use messages::{Service, Topic};
use serde::{Deserialize, Serialize};

use super::topic::{self, BiasedField, TopicName};
use crate::quantity::{Core, Count, DelayMs, Duration, Megabytes, Probability, Shift};

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
        #[serde(flatten, serialize_with = "topic::with_topic")]
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
