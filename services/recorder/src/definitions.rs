//! Channels of a file that carry our messages.

use crate::schema;
use bags::mcap::Record;
use mcap::records::{Channel, SchemaHeader};
use messages::{TOPICS, Topic};
use std::collections::BTreeMap;

/// Longest name that is kept, bytes.
const LONGEST_NAME: usize = 256;

/// Encoding of our types' definitions.
pub(crate) const SCHEMA_ENCODING: &str = "ros2msg";
pub(crate) const MESSAGE_ENCODING: &str = "cdr";

/// Schemas and channels seen so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Definitions {
    /// Fingerprint of each type, and the topic of ours that has a type of that name.
    schemas: BTreeMap<u16, (Option<u64>, Option<Topic>)>,
    channels: BTreeMap<u16, Topic>,
    /// Other topics with a type of ours: their names, and our topic.
    renamed: BTreeMap<u16, (String, Topic)>,
    other_layout: Option<String>,
}

impl Definitions {
    /// Takes a record of a schema or of a channel.
    pub(crate) fn take(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, data } => self.schema(header, data),
            Record::Channel(channel) => self.channel(channel),
            _ => {}
        }
    }

    fn schema(&mut self, schema: &SchemaHeader, definition: &[u8]) {
        let fingerprint = (schema.encoding == SCHEMA_ENCODING)
            .then(|| schema::fingerprint(&String::from_utf8_lossy(definition)));
        let ours = TOPICS.into_iter().find(|topic| topic.layout().type_name == schema.name);
        self.schemas.insert(schema.id, (fingerprint, ours));
    }

    fn channel(&mut self, channel: &Channel) {
        let (fingerprint, ours) = self.schemas.get(&channel.schema_id).copied().unwrap_or_default();
        let own = |topic: Topic| schema::fingerprint(&schema::ros2_definition(topic.layout()));
        let is_cdr = channel.message_encoding == MESSAGE_ENCODING;
        match Topic::by_name(&channel.topic) {
            Some(topic) if fingerprint == Some(own(topic)) && is_cdr => {
                self.channels.insert(channel.id, topic);
            }
            Some(_) => {
                self.other_layout.get_or_insert_with(|| channel.topic.clone());
            }
            // A topic that others added to the file is theirs.
            None => {
                if let Some(ours) = ours.filter(|_| channel.topic.len() <= LONGEST_NAME) {
                    self.renamed.insert(channel.id, (channel.topic.clone(), ours));
                }
            }
        }
    }

    pub(crate) fn topic(&self, channel: u16) -> Option<Topic> {
        self.channels.get(&channel).copied()
    }

    /// A topic of ours whose messages have another layout than this program's.
    pub(crate) fn other_layout(&self) -> Option<&str> {
        self.other_layout.as_deref()
    }

    /// A topic that carries a type of ours in the place of ours, which the file does not have.
    pub(crate) fn renamed(&self) -> Option<(&str, Topic)> {
        let is_there = |ours: &Topic| self.channels.values().any(|topic| topic == ours);
        let mut renamed = self.renamed.values().filter(|(_, ours)| !is_there(ours));
        renamed.next().map(|(name, ours)| (name.as_str(), *ours))
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
