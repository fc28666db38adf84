//! Channels of a file that carry our messages.

use crate::schema;
use bags::mcap::{self as format, Channel, Malformed, Schema, opcode};
use messages::{TOPICS, Topic};
use std::collections::BTreeMap;

/// Longest name that is kept, bytes.
const LONGEST_NAME: usize = 256;

/// Encoding of our types' definitions.
pub(crate) const SCHEMA_ENCODING: &str = "ros2msg";
/// Encoding of our messages.
pub(crate) const MESSAGE_ENCODING: &str = "cdr";

/// Schemas and channels seen so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Definitions {
    /// Fingerprints of the types.
    schemas: BTreeMap<u16, u64>,
    /// Names of the types, and by channel name and type of the topic, ours and others.
    types: BTreeMap<u16, String>,
    listed: BTreeMap<u16, (String, u16)>,
    channels: BTreeMap<u16, Topic>,
    other_layout: Option<String>,
}

impl Definitions {
    /// Takes a record of a schema or of a channel.
    pub(crate) fn take(&mut self, opcode: u8, body: &[u8]) -> Result<(), Malformed> {
        match opcode {
            opcode::SCHEMA => self.schema(&format::schema(body)?),
            _ => self.channel(&format::channel(body)?),
        }
        Ok(())
    }

    /// Adds those of another part of the file.
    pub(crate) fn extend(&mut self, other: Self) {
        self.schemas.extend(other.schemas);
        self.types.extend(other.types);
        self.listed.extend(other.listed);
        self.channels.extend(other.channels);
        self.other_layout = self.other_layout.take().or(other.other_layout);
    }

    pub(crate) fn schema(&mut self, schema: &Schema<'_>) {
        if schema.encoding == SCHEMA_ENCODING {
            let text = String::from_utf8_lossy(schema.definition);
            self.schemas.insert(schema.id, schema::fingerprint(&text));
        }
        if schema.name.len() <= LONGEST_NAME {
            self.types.insert(schema.id, schema.name.to_owned());
        }
    }

    pub(crate) fn channel(&mut self, channel: &Channel<'_>) {
        if channel.topic.len() <= LONGEST_NAME {
            self.listed.insert(channel.id, (channel.topic.to_owned(), channel.schema));
        }
        // A topic that others added to the file is theirs.
        let Some(topic) = Topic::by_name(channel.topic) else { return };
        let is_ours = self.schemas.get(&channel.schema) == Some(&ours(topic));
        if is_ours && channel.encoding == MESSAGE_ENCODING {
            self.channels.insert(channel.id, topic);
        } else {
            self.other_layout.get_or_insert_with(|| channel.topic.to_owned());
        }
    }

    pub(crate) fn topic(&self, channel: u16) -> Option<Topic> {
        self.channels.get(&channel).copied()
    }

    /// A topic of ours whose messages have another layout than this program's.
    pub(crate) fn other_layout(&self) -> Option<&str> {
        self.other_layout.as_deref()
    }

    /// Topics that carry a type of ours in the place of ours, which the file does not have.
    pub(crate) fn renamed(&self) -> impl Iterator<Item = (&str, Topic)> {
        self.listed().filter_map(|(channel, name, type_name)| {
            let ours = TOPICS.into_iter().find(|topic| topic.layout().type_name == type_name)?;
            let is_there = self.channels.values().any(|topic| *topic == ours);
            (!is_there && !self.channels.contains_key(&channel)).then_some((name, ours))
        })
    }

    /// True before the first topic of ours.
    pub(crate) fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.other_layout.is_none()
    }

    /// Channel, name of the topic and name of its type, of every channel.
    pub(crate) fn listed(&self) -> impl Iterator<Item = (u16, &str, &str)> {
        self.listed.iter().map(|(channel, (topic, schema))| {
            (*channel, topic.as_str(), self.types.get(schema).map_or("", String::as_str))
        })
    }

    /// Messages by topic from their number by channel; `None` if a topic has no channel.
    pub(crate) fn counts(&self, channels: &BTreeMap<u16, u64>) -> Option<BTreeMap<Topic, u64>> {
        let mut counts = BTreeMap::new();
        for (channel, topic) in &self.channels {
            *counts.entry(*topic).or_default() += channels.get(channel).copied().unwrap_or(0);
        }
        (counts.len() == TOPICS.len()).then_some(counts)
    }
}

fn ours(topic: Topic) -> u64 {
    schema::fingerprint(&schema::ros2_definition(topic.layout()))
}
