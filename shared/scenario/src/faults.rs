//! `[[faults]]`: what goes wrong, when, and for how long.

use serde::{Deserialize, Serialize};

use super::document::Problem;
use super::quantity::{Core, Count, DelayMs, Duration, Megabytes, Probability, Shift, Speed, Time};
use messages::Service;
use messages::Topic;

/// Most faults in one scenario.
pub const MAX_FAULTS: usize = 64;

/// A fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What happens.
    pub kind: Kind,
    /// When it begins, s of run time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<Time>,
    /// When it begins, by what the ego does; all conditions that are given must hold at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<Condition>,
    /// How long it lasts, s; absent: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<Duration>,
    /// The service that it acts on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub service: Option<Service>,
    /// The topic whose messages it acts on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub topic: Option<TopicName>,
    /// Part of the messages that it acts on.
    #[serde(default = "always")]
    pub probability: Probability,
    /// `delay`: by how much, ms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_ms: Option<DelayMs>,
    /// `delay`: on top of that, up to so much more, ms, anew for each message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jitter_ms: Option<DelayMs>,
    /// `corrupt`: bits flipped in a message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bits: Option<Count>,
    /// `bias`: the figure that is off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<BiasedField>,
    /// `bias`: by how much, in the figure's unit. `stale` and `clock-step`: by how much the stamps are
    /// shifted, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amount: Option<Shift>,
    /// `hog`: the core that is kept busy; absent: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub core: Option<Core>,
    /// `memory`: memory that is taken and touched, MiB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub megabytes: Option<Megabytes>,
    /// `restart-storm`: how often the service is killed, as soon as it is back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Count>,
}

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The service's process is killed (SIGKILL).
    Kill,
    /// The service's process is stopped (SIGSTOP), and continued after `for_s`.
    Stop,
    /// The service's process is killed again and again, `times` times.
    RestartStorm,
    /// Processes of no service keep the processor busy.
    Hog,
    /// A process of no service takes memory.
    Memory,
    /// Messages arrive late.
    Delay,
    /// Messages do not arrive.
    Drop,
    /// Messages arrive twice.
    Duplicate,
    /// Messages arrive after their successor.
    Reorder,
    /// Bits of messages are flipped on the way.
    Corrupt,
    /// The sender repeats the content of its last message under fresh stamps.
    Freeze,
    /// The sender's figure is off.
    Bias,
    /// The sender's acquisition stamps are old.
    Stale,
    /// The service's clock is off: all its stamps are.
    ClockStep,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 14] = [
        Self::Kill,
        Self::Stop,
        Self::RestartStorm,
        Self::Hog,
        Self::Memory,
        Self::Delay,
        Self::Drop,
        Self::Duplicate,
        Self::Reorder,
        Self::Corrupt,
        Self::Freeze,
        Self::Bias,
        Self::Stale,
        Self::ClockStep,
    ];

    /// Name in files, on the command line and in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kill => "kill",
            Self::Stop => "stop",
            Self::RestartStorm => "restart-storm",
            Self::Hog => "hog",
            Self::Memory => "memory",
            Self::Delay => "delay",
            Self::Drop => "drop",
            Self::Duplicate => "duplicate",
            Self::Reorder => "reorder",
            Self::Corrupt => "corrupt",
            Self::Freeze => "freeze",
            Self::Bias => "bias",
            Self::Stale => "stale",
            Self::ClockStep => "clock-step",
        }
    }

    /// True if it acts on processes, by the launcher's hand.
    #[must_use]
    pub const fn is_of_processes(self) -> bool {
        matches!(self, Self::Kill | Self::Stop | Self::RestartStorm | Self::Hog | Self::Memory)
    }

    /// True if it acts on messages between their sender and a receiver.
    #[must_use]
    pub const fn is_of_channels(self) -> bool {
        matches!(self, Self::Delay | Self::Drop | Self::Duplicate | Self::Reorder | Self::Corrupt)
    }

    /// True if it acts on messages in their sender.
    #[must_use]
    pub const fn is_of_senders(self) -> bool {
        !self.is_of_processes() && !self.is_of_channels()
    }
}

impl std::str::FromStr for Kind {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("unknown fault `{name}`, expected one of {names}")
        })
    }
}

/// What must be so for a fault to begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The ego is beyond this place, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_above_m: Option<super::quantity::Distance>,
    /// The ego is slower, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_below_mps: Option<Speed>,
    /// The ego is faster, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_above_mps: Option<Speed>,
}

impl Condition {
    /// True if it holds for an ego there, so fast.
    #[must_use]
    pub fn holds(&self, position_m: f64, speed_mps: f64) -> bool {
        self.position_above_m.is_none_or(|limit| position_m > limit.value())
            && self.speed_below_mps.is_none_or(|limit| speed_mps < limit.value())
            && self.speed_above_mps.is_none_or(|limit| speed_mps > limit.value())
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

/// A topic by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct TopicName(pub Topic);

impl TryFrom<String> for TopicName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let sensors =
            [Topic::Odometry, Topic::RadarTracks, Topic::Spat, Topic::Map, Topic::Command];
        sensors.into_iter().find(|topic| topic.name() == name).map(Self).ok_or_else(|| {
            let names = sensors.map(Topic::name).join(", ");
            format!("no messages of `{name}` can be disturbed, expected one of {names}")
        })
    }
}

impl From<TopicName> for String {
    fn from(name: TopicName) -> Self {
        name.0.name().into()
    }
}

fn always() -> Probability {
    Probability::of(1.0)
}

impl Fault {
    /// A fault of that kind with nothing else said.
    #[must_use]
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            at_s: None,
            when: None,
            for_s: None,
            service: None,
            topic: None,
            probability: always(),
            delay_ms: None,
            jitter_ms: None,
            bits: None,
            field: None,
            amount: None,
            core: None,
            megabytes: None,
            times: None,
        }
    }

    /// Run time after which it is over once it began at `begun_ns`, ns.
    #[must_use]
    pub fn end_ns(&self, begun_ns: i64) -> i64 {
        self.for_s.map_or(i64::MAX, |length| begun_ns.saturating_add_unsigned(length.nanoseconds()))
    }

    /// Checks that what the kind needs is there and nothing else is; `path` is its place.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self, path: &str) -> Result<(), Problem> {
        let kind = self.kind.name();
        let given = [
            ("service", self.service.is_some()),
            ("topic", self.topic.is_some()),
            ("delay_ms", self.delay_ms.is_some()),
            ("jitter_ms", self.jitter_ms.is_some()),
            ("bits", self.bits.is_some()),
            ("field", self.field.is_some()),
            ("amount", self.amount.is_some()),
            ("core", self.core.is_some()),
            ("megabytes", self.megabytes.is_some()),
            ("times", self.times.is_some()),
        ];
        let (needed, allowed): (&[&str], &[&str]) = match self.kind {
            Kind::Kill | Kind::Stop => (&["service"], &[]),
            Kind::RestartStorm => (&["service"], &["times"]),
            Kind::Hog => (&[], &["core"]),
            Kind::Memory => (&["megabytes"], &[]),
            Kind::Delay => (&["topic", "delay_ms"], &["jitter_ms"]),
            Kind::Drop | Kind::Duplicate | Kind::Reorder | Kind::Freeze => (&["topic"], &[]),
            Kind::Corrupt => (&["topic"], &["bits"]),
            Kind::Bias => (&["topic", "field", "amount"], &[]),
            Kind::Stale => (&["topic", "amount"], &[]),
            Kind::ClockStep => (&["service", "amount"], &[]),
        };
        for (key, given) in given {
            if needed.contains(&key) && !given {
                return Err(Problem::new(
                    path,
                    format!("a fault of kind `{kind}` needs `{key}`"),
                    format!("`{key}`"),
                ));
            }
            if given && !needed.contains(&key) && !allowed.contains(&key) {
                return Err(Problem::new(
                    format!("{path}.{key}"),
                    format!("`{key}` means nothing for a fault of kind `{kind}`"),
                    "no such key here",
                ));
            }
        }
        if self.for_s.is_some() && matches!(self.kind, Kind::Kill | Kind::RestartStorm) {
            return Err(Problem::new(
                format!("{path}.for_s"),
                format!(
                    "`for_s` means nothing for a fault of kind `{kind}`, which is over at once"
                ),
                "no such key here",
            ));
        }
        if let (Some(field), Some(topic)) = (self.field, self.topic)
            && field.topic() != topic.0
        {
            return Err(Problem::new(
                format!("{path}.field"),
                format!("{} has no such figure", topic.0.name()),
                format!("a figure of that topic, or topic = \"{}\"", field.topic().name()),
            ));
        }
        if self.at_s.is_some() && self.when.is_some() {
            return Err(Problem::new(
                format!("{path}.when"),
                "the fault has a time and a condition",
                "one of `at_s` and `when`",
            ));
        }
        Ok(())
    }
}
