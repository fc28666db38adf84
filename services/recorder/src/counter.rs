//! Counting what is recorded, and by the sequence numbers what is not.

use crate::{Tally, TopicTally};
use messages::e2e::profile7;
use messages::{Header, Service, TOPICS, Topic};
use std::collections::BTreeMap;

/// Counts messages and the gaps in their sequence numbers. A number out of order counts if the message's protection
/// holds. The number of a damaged or foreign message on our topics shows nothing about losses.
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
        tally.messages += 1;
        let last = self.last.get(&(topic, header.source)).copied().unwrap_or_default();
        // Every incarnation counts from 1.
        let before = if last.0 == header.incarnation { last.1 } else { 0 };
        let expected = before.saturating_add(1);
        let is_next = header.sequence == expected;
        let is_intact = || {
            let in_use = topic.layout().bytes_in_use(message);
            profile7::check(&message[..in_use], topic.data_id(header.source)).is_ok()
        };
        if !is_next && !is_intact() {
            return;
        }
        tally.lost = tally.lost.saturating_add(header.sequence.saturating_sub(expected));
        self.last.insert((topic, header.source), (header.incarnation, header.sequence));
    }

    /// Counts so far.
    pub(crate) fn tally(&self) -> Tally {
        let of = |topic| self.topics.get(&topic).copied().unwrap_or_default();
        let incarnations = Service::ALL.into_iter().filter_map(|service| {
            let heard = self.last.iter().filter(|((_, source), _)| *source == service.to_wire());
            let newest = heard.map(|(_, (incarnation, _))| *incarnation).max()?;
            Some((service.name().to_owned(), newest.saturating_add(1)))
        });
        Tally {
            topics: TOPICS.map(|topic| (topic.name().to_owned(), of(topic))).into(),
            incarnations: incarnations.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Message, Odometry};

    fn message(source: u32, sequence: u64) -> Odometry {
        let mut message: Odometry = bytemuck::Zeroable::zeroed();
        message.header.source = source;
        message.header.sequence = sequence;
        message
    }

    fn protected(sequence: u64) -> Odometry {
        let source = Service::Plant.to_wire();
        let mut message = message(source, sequence);
        let data_id = Odometry::TOPIC.data_id(source);
        profile7::protect(bytemuck::bytes_of_mut(&mut message), data_id, sequence as u32);
        message
    }

    fn counted(messages: impl IntoIterator<Item = Odometry>) -> Tally {
        let mut counter = Counter::default();
        for message in messages {
            counter.count(Odometry::TOPIC, bytemuck::bytes_of(&message));
        }
        counter.tally()
    }

    #[test]
    fn a_gap_in_the_numbers_of_protected_messages_is_lost() {
        let tally = counted([1, 2, 5, 6].map(protected));
        assert_eq!((tally.messages(), tally.lost()), (4, 2));
    }

    #[test]
    fn numbers_of_others_and_of_damaged_messages_are_no_losses() {
        let plant = Service::Plant.to_wire();
        let mut damaged = protected(3);
        damaged.speed_mps = 1.0;
        let mut incarnation = message(plant, 9);
        incarnation.header.incarnation = u32::MAX;
        let odd = [message(u32::MAX, u64::MAX), message(plant, u64::MAX), incarnation];
        let tally =
            counted([protected(1), protected(2), damaged, protected(4)].into_iter().chain(odd));
        assert_eq!((tally.messages(), tally.lost()), (7, 0));
        assert_eq!(tally.incarnations["plant"], 1);
    }
}
