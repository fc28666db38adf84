//! The messages that a fault can act on, and the figures in them.

use messages::{Role, TOPICS, Topic};
use scenario_derive::tables;
use serde::{Deserialize, Serialize};

tables! {
    /// A figure that a `bias` can falsify.
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
}

impl BiasedField {
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
    /// Topics whose messages can be disturbed: those that a function of the vehicle reads.
    pub fn all() -> impl Iterator<Item = Topic> {
        TOPICS.into_iter().filter(|topic| topic.role() == Role::Function)
    }
}

impl TryFrom<String> for TopicName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let found = Self::all().find(|topic| topic.name() == name);
        found.map(Self).ok_or_else(|| format!("no messages of `{name}` can be disturbed"))
    }
}

impl From<TopicName> for String {
    fn from(name: TopicName) -> Self {
        name.0.name().into()
    }
}
