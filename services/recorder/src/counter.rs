//! Counting what is recorded, and by the sequence numbers what is not.

use crate::{Tally, TopicTally};
use messages::Service;
use messages::{Header, TOPICS, Topic};
use std::collections::BTreeMap;

/// Counts messages and the gaps in their sequence numbers.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    topics: BTreeMap<Topic, TopicTally>,
    /// Incarnation and sequence number of the last message of each sender on each topic.
    last: BTreeMap<(Topic, u32), (u32, u64)>,
}

impl Counter {
    /// Counts the message whose bytes begin with its header.
    pub(crate) fn count(&mut self, topic: Topic, message: &[u8]) {
        let header: Header = bytemuck::pod_read_unaligned(&message[..size_of::<Header>()]);
        let tally = self.topics.entry(topic).or_default();
        let last = self.last.entry((topic, header.source)).or_default();
        // Every incarnation counts from 1.
        let before = if last.0 == header.incarnation { last.1 } else { 0 };
        tally.messages += 1;
        tally.lost += header.sequence.saturating_sub(before + 1);
        *last = (header.incarnation, header.sequence);
    }

    /// What was counted so far.
    pub(crate) fn tally(&self) -> Tally {
        let of = |topic| self.topics.get(&topic).copied().unwrap_or_default();
        let incarnations = Service::ALL.into_iter().filter_map(|service| {
            let heard = self.last.iter().filter(|((_, source), _)| *source == service.to_wire());
            let newest = heard.map(|(_, (incarnation, _))| *incarnation).max()?;
            Some((service.name().to_owned(), newest + 1))
        });
        Tally {
            topics: TOPICS.map(|topic| (topic.name().to_owned(), of(topic))).into(),
            incarnations: incarnations.collect(),
        }
    }
}
