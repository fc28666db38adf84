//! The messages that a fault can act on, and the figures in them.

use messages::Topic;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

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

/// Writes a biased field with its topic beside it.
pub(super) fn with_topic<S: Serializer>(
    field: &BiasedField,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut keys = serializer.serialize_struct("BiasedField", 2)?;
    keys.serialize_field("topic", field.topic().name())?;
    keys.serialize_field("field", field)?;
    keys.end()
}

/// A topic by its name, one whose messages can be disturbed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct TopicName(pub Topic);

impl TopicName {
    /// Topics whose messages can be disturbed.
    pub const ALL: [Topic; 10] = [
        Topic::Odometry,
        Topic::Powertrain,
        Topic::RadarDetections,
        Topic::RadarTracks,
        Topic::RadioFrames,
        Topic::Spat,
        Topic::Map,
        Topic::Preview,
        Topic::Command,
        Topic::Brake,
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
