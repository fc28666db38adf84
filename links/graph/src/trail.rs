//! The content of a message: the common header, then the trail of each chain that goes over its topic.
//!
//! ```text
//! Header │ trail of chain a: acquired, (due, idle, start, end) of each node so far │ trail of chain b │ rest
//! ```
//!
//! So the last node of a chain finds all stamps of the way in one message, as the car's plant does in a command. Stamps
//! are `CLOCK_MONOTONIC` ns.

use crate::plan::{Graph, Topic};
use messages::Header;
use messages::e2e::profile7;
use runtime::chain::part;

/// Stamps of one node: its release, the start of its wait, the start of the cycle, and its end.
pub const STAMPS: usize = 4;
/// Parts of a reaction that a node makes up: wait, wake-up, work.
pub const PARTS: usize = 3;
/// Messages up to this length are protected whole. In longer ones header and trails are, as in the car's.
const PROTECTED_WHOLE: usize = 4 << 10;

/// Words of the trail of a chain over this number of nodes.
const fn words(nodes: usize) -> usize {
    1 + STAMPS * nodes
}

/// Place of the trail of `chain` in the messages of `topic`; `None` if the chain takes another way.
pub fn place(topic: &Topic, chain: usize) -> Option<std::ops::Range<usize>> {
    let mut start = size_of::<Header>();
    for &(of, nodes) in &topic.chains {
        let end = start + 8 * words(nodes);
        if of == chain {
            return Some(start..end);
        }
        start = end;
    }
    None
}

/// Bytes of header and trails.
pub fn used(topic: &Topic) -> usize {
    size_of::<Header>() + topic.chains.iter().map(|&(_, nodes)| 8 * words(nodes)).sum::<usize>()
}

/// Length of a topic's messages, bytes: at least that of header and trails.
pub fn length(topic: &Topic) -> usize {
    topic.bytes.max(used(topic))
}

/// The protected part of a message.
fn protected(topic: &Topic) -> usize {
    if length(topic) <= PROTECTED_WHOLE { length(topic) } else { used(topic) }
}

/// Data ID of the end-to-end protection of a topic's messages: topic and sender.
fn data_id(topic: usize, writer: usize) -> u32 {
    (topic as u32 + 1) << 16 | (writer as u32 + 1)
}

/// Writes header and trails into a message of `topic`, and protects it.
pub fn write<'a>(
    bytes: &mut [u8],
    graph: &Graph,
    topic: usize,
    header: &Header,
    trails: impl Iterator<Item = (usize, &'a [i64])>,
) {
    let of = &graph.topics[topic];
    bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(header));
    for (chain, trail) in trails {
        let Some(place) = place(of, chain) else { continue };
        // A chain whose message did not come yet leaves zeros.
        bytes[place.clone()].fill(0);
        for (to, stamp) in bytes[place].chunks_exact_mut(8).zip(trail) {
            to.copy_from_slice(&stamp.to_le_bytes());
        }
    }
    let counter = header.sequence as u32;
    let id = data_id(topic, of.writer.unwrap_or_default());
    profile7::protect(&mut bytes[..protected(of)], id, counter);
}

/// The header of a message that passes the end-to-end check.
pub fn read(bytes: &[u8], graph: &Graph, topic: usize) -> Option<Header> {
    let of = &graph.topics[topic];
    let id = data_id(topic, of.writer.unwrap_or_default());
    profile7::check(bytes.get(..protected(of))?, id).ok()?;
    Some(bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]))
}

/// Appends the stamps of a trail to `to`; false if its chain has not begun.
pub fn stamps(bytes: &[u8], to: &mut Vec<i64>) -> bool {
    let word = |bytes: &[u8]| i64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    to.extend(bytes.chunks_exact(8).map(word));
    to.first().is_some_and(|acquired_ns| *acquired_ns != 0)
}

/// The parts of a reaction whose stamps are `trail`, [`PARTS`] for each node, into `parts`. Returns the waits that are
/// designed, ns: those for the release of a timer, or for another topic.
pub fn parts(trail: &[i64], parts: &mut Vec<i64>) -> i64 {
    parts.clear();
    let mut reached_ns = trail[0];
    let mut designed_ns = 0;
    for stamps in trail[1..].chunks_exact(STAMPS) {
        let [due, idle, start, end] = stamps else { continue };
        let sent_ns = reached_ns;
        let is_source = parts.is_empty();
        let wait = part(&mut reached_ns, if is_source { *due } else { *due.max(idle) });
        designed_ns += wait.min((due - sent_ns).max(0));
        parts.extend([wait, part(&mut reached_ns, *start), part(&mut reached_ns, *end)]);
    }
    designed_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_and_waits_for_a_timer_are_designed() {
        // Released at 100, started 5 late, published at 130; the reader is due at 200, starts at 203 and ends at 220.
        let trail = [100, 100, 90, 105, 130, 200, 150, 203, 220];
        let mut all = Vec::new();
        assert_eq!(parts(&trail, &mut all), 70);
        assert_eq!(all, [0, 5, 25, 70, 3, 17]);
        // A reader that was busy until 150 waits by accident.
        let busy = [100, 100, 90, 105, 130, 130, 150, 152, 160];
        assert_eq!(parts(&busy, &mut all), 0);
        assert_eq!((&all[3..], all.iter().sum::<i64>()), (&[20, 2, 8][..], 60));
    }

    #[test]
    fn trails_of_two_chains_stand_in_one_message_and_a_flipped_bit_is_found() {
        let text = "name = \"two\"\ntopics = { a = 8, b = 8 }\n\
            [[nodes]]\nname = \"x\"\nperiod_ms = 1\npublishes = [\"a\"]\n\
            [[nodes]]\nname = \"y\"\ntrigger = [\"a\"]\npublishes = [\"b\"]\n\
            [[nodes]]\nname = \"z\"\ntrigger = [\"b\"]\n\
            [[chains]]\nname = \"whole\"\npath = [\"x\", \"y\", \"z\"]\n\
            [[chains]]\nname = \"end\"\npath = [\"y\", \"z\"]\n";
        let graph = Graph::parse("two.toml", text).expect("right");
        let mut bytes = vec![0; length(&graph.topics[1])];
        let header = Header::new(7, 5, messages::Origins::NONE);
        let (whole, end) = ([1, 2, 3, 4, 5, 6, 7, 8, 9], [6, 6, 7, 8, 9]);
        let trails = [(0, &whole[..]), (1, &end[..])];
        write(&mut bytes, &graph, 1, &header, trails.into_iter());
        assert_eq!(read(&bytes, &graph, 1).map(|header| header.step), Some(7));
        for (chain, stamped) in trails {
            let mut found = Vec::new();
            let place = place(&graph.topics[1], chain).expect("both go over it");
            assert!(stamps(&bytes[place], &mut found));
            assert_eq!(found, stamped);
        }
        assert!(place(&graph.topics[0], 1).is_none(), "it begins later");
        bytes[size_of::<Header>() + 3] ^= 1;
        assert!(read(&bytes, &graph, 1).is_none());
    }
}
