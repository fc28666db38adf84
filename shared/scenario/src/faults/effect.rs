//! The kinds of faults: each is one row with its name, its target and its keys.

use messages::{Service, Topic};
use scenario_derive::tables;
use serde::{Deserialize, Serialize};

use super::rows::kinds;
use super::topic::{BiasedField, TopicName};
use crate::quantity::{Core, Count, DelayMs, Duration, Megabytes, Probability, Shift};
use crate::schema::Schema;

/// Act of the fault. The kinds of its families are disjoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Effect {
    /// To processes, by the launcher's hand.
    Process(ProcessFault),
    /// To messages between their sender and a receiver.
    Channel(ChannelFault),
    Sender(SenderFault),
}

kinds! {
    /// A fault of processes.
    ProcessFault {
        /// The service's process is killed (SIGKILL).
        Kill = "kill", on Target::Service(*service) => {
            /// The service that it acts on.
            service: Service,
        }
        /// The service's process is stopped (SIGSTOP), and continued after `for_s`.
        Stop = "stop", on Target::Service(*service), lasting *for_s => {
            /// The service that it acts on.
            service: Service,
            /// Duration, s; absent: to the end of the run.
            #[serde(skip_serializing_if = "Option::is_none")]
            for_s: Option<Duration>,
        }
        /// The service's process is killed again and again, as soon as it is back.
        RestartStorm = "restart-storm", on Target::Service(*service) => {
            /// The service that it acts on.
            service: Service,
            /// Number of kills.
            #[serde(default = "count::<3>")]
            times: Count,
            /// Time from the start of each next process to its kill, ms. If absent, it is killed as soon as it takes
            /// part.
            #[serde(skip_serializing_if = "Option::is_none")]
            after_start_ms: Option<DelayMs>,
        }
        /// A process of the run that is not a service is killed (SIGKILL).
        KillHelper = "kill-helper", on Target::Helper(*helper) => {
            /// The process that is killed; the recorder only where the run is recorded.
            helper: Helper,
        }
        /// Processes of no service keep the processor busy.
        Hog = "hog", on Target::Machine, lasting *for_s => {
            /// The core that is kept busy; absent: all.
            #[serde(skip_serializing_if = "Option::is_none")]
            core: Option<Core>,
            /// Duration, s; absent: to the end of the run.
            #[serde(skip_serializing_if = "Option::is_none")]
            for_s: Option<Duration>,
        }
        /// A process of no service takes memory.
        Memory = "memory", on Target::Machine, lasting *for_s => {
            /// Memory that is taken and touched, MiB.
            megabytes: Megabytes,
            /// Duration, s; absent: to the end of the run.
            #[serde(skip_serializing_if = "Option::is_none")]
            for_s: Option<Duration>,
        }
    }

    /// A fault of a message on its way.
    Disturbance {
        /// It arrives late.
        Delay = "delay" => {
            /// Least delay of a message, ms.
            delay_ms: DelayMs,
            /// Largest random addition to it, ms, drawn for each message.
            #[serde(default = "no_jitter")]
            jitter_ms: DelayMs,
        }
        /// It does not arrive.
        Drop = "drop" => {}
        /// It arrives twice.
        Duplicate = "duplicate" => {}
        /// It arrives after its successor.
        Reorder = "reorder" => {}
        /// Bits of it are flipped.
        Corrupt = "corrupt" => {
            /// Number of flipped bits in a message.
            #[serde(default = "count::<1>")]
            bits: Count,
        }
    }

    /// A false content of a message.
    Falsification {
        /// The content of the last message is repeated under fresh stamps.
        Freeze = "freeze", on Target::Topic(topic.0) => {
            /// The topic whose messages it acts on.
            topic: TopicName,
        }
        /// A figure is off.
        Bias = "bias", on Target::Topic(topic.0) => {
            /// The topic whose messages it acts on.
            topic: TopicName,
            /// The figure that is off.
            field: BiasedField,
            /// Value added to the figure, in its unit.
            amount: Shift,
        }
        /// The acquisition stamps are old.
        Stale = "stale", on Target::Topic(topic.0) => {
            /// The topic whose messages it acts on.
            topic: TopicName,
            /// Age added to the stamps, s.
            amount: Shift,
        }
        /// The service's clock is off: all its stamps are.
        ClockStep = "clock-step", on Target::Service(*service) => {
            /// The service that it acts on.
            service: Service,
            /// Time by which the clock is ahead, s.
            amount: Shift,
        }
    }
}

/// A fault of the channel between a topic and its receivers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFault {
    #[serde(flatten)]
    pub disturbance: Disturbance,
    pub topic: TopicName,
    #[serde(flatten)]
    pub extent: Extent,
}

/// A fault of a sender: messages that are intact and whose content is false.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SenderFault {
    #[serde(flatten)]
    pub falsification: Falsification,
    #[serde(flatten)]
    pub extent: Extent,
}

/// Messages that a fault acts on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Extent {
    /// Probability of each message to be affected.
    #[serde(default = "always")]
    pub probability: Probability,
    /// Duration, s; absent: to the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<Duration>,
}

tables! {
    /// A process of a run that is not a service.
    pub enum Helper {
        /// Writes the recording.
        Recorder,
        /// Cleans up after a launcher that was killed.
        Janitor,
        /// Starts and supervises all others.
        Launcher,
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A service: its process, or all its messages.
    Service(Service),
    /// A process that is not a service.
    Helper(Helper),
    Topic(Topic),
    Machine,
}

impl Effect {
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Process(fault) => fault.kind(),
            Self::Channel(fault) => fault.disturbance.kind(),
            Self::Sender(fault) => fault.falsification.kind(),
        }
    }

    pub fn target(&self) -> Target {
        let own = match self {
            Self::Process(fault) => fault.target(),
            Self::Channel(fault) => Some(Target::Topic(fault.topic.0)),
            Self::Sender(fault) => fault.falsification.target(),
        };
        own.unwrap_or(Target::Machine)
    }

    /// Messages that it acts on, if it acts on messages.
    pub const fn extent(&self) -> Option<Extent> {
        match self {
            Self::Process(_) => None,
            Self::Channel(ChannelFault { extent, .. })
            | Self::Sender(SenderFault { extent, .. }) => Some(*extent),
        }
    }

    /// Duration; `None` if it lasts to the end of the run or is over at once.
    pub fn length(&self) -> Option<Duration> {
        match self {
            Self::Process(fault) => fault.length(),
            Self::Channel(_) | Self::Sender(_) => self.extent()?.for_s,
        }
    }

    /// Run time of its end if it began at `begun_ns`, ns.
    pub fn end_ns(&self, begun_ns: i64) -> i64 {
        let length = self.length();
        length.map_or(i64::MAX, |length| begun_ns.saturating_add_unsigned(length.nanoseconds()))
    }

    pub const fn of_channels(&self) -> Option<&ChannelFault> {
        if let Self::Channel(fault) = self { Some(fault) } else { None }
    }

    pub const fn of_senders(&self) -> Option<&SenderFault> {
        if let Self::Sender(fault) = self { Some(fault) } else { None }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

fn count<const N: u16>() -> Count {
    Count::of(N)
}

fn no_jitter() -> DelayMs {
    DelayMs::of(0)
}

fn always() -> Probability {
    Probability::of(1.0)
}
