//! A chain: its trail in messages, and its reactions.
//!
//! A message is the common header, then the trail of each chain that goes over its topic.
//!
//! ```text
//! Header │ trail of chain a: acquired, (due, idle, start, end) of each node so far │ trail of chain b │ rest
//! ```
//!
//! So the last node of a chain finds all stamps of the way in one message, as the car's plant does in a command. Stamps
//! are `CLOCK_MONOTONIC` ns.

use crate::plan::Graph;
use messages::Header;
use messages::e2e::profile7;
use runtime::chain::{ChainTimes, part};
use runtime::statistics::Latencies;
use runtime::{Count, Figures, Group, RuntimeError};
use std::ops::Range;

/// Stamps of a node: its release, the start of its wait, the start of the cycle, and its end.
pub const STAMPS: usize = 4;
/// Parts of a reaction that a node makes up: wait, wake-up, work.
pub const PARTS: usize = 3;
/// Blocks of equal length in a run. A gate compares two runs block by block.
pub const BLOCKS: usize = 12;
/// Messages up to this length are protected whole. In longer ones header and trails are, as in the car's.
const PROTECTED_WHOLE: usize = 4 << 10;

/// Places in the messages of a topic.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Length of a message, bytes: at least header and trails.
    pub length: usize,
    /// Bytes of header and trails.
    pub used: usize,
    protected: usize,
    /// The trail of each chain.
    trails: Vec<(usize, Range<usize>)>,
    data_id: u32,
}

impl Layout {
    pub fn of(graph: &Graph, topic: &str) -> Self {
        let mut used = size_of::<Header>();
        let mut trails = Vec::new();
        for (chain, nodes) in graph.chains_over(topic) {
            let begin = used;
            used += 8 * (1 + STAMPS * nodes);
            trails.push((chain, begin..used));
        }
        let data_id = graph.topics.keys().take_while(|known| *known != topic).count() as u32;
        let length = used.max(graph.topics[topic].value() as usize);
        let protected = if length <= PROTECTED_WHOLE { length } else { used };
        Self { length, used, protected, trails, data_id }
    }

    /// Writes header and trails into a message, and protects it. A chain without a trail leaves zeros.
    pub fn write<'a>(&self, bytes: &mut [u8], header: &Header, trail: impl Fn(usize) -> &'a [i64]) {
        bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(header));
        for (chain, place) in &self.trails {
            let (to, trail) = (&mut bytes[place.clone()], trail(*chain));
            to.fill(0);
            to[..size_of_val(trail)].copy_from_slice(bytemuck::cast_slice(trail));
        }
        profile7::protect(&mut bytes[..self.protected], self.data_id, header.sequence as u32);
    }

    /// The header of a message that passes the end-to-end check.
    pub fn read(&self, bytes: &[u8]) -> Option<Header> {
        profile7::check(bytes.get(..self.protected)?, self.data_id).ok()?;
        Some(bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]))
    }

    /// Puts the trail of a chain into `to`, which stays empty if the chain has not begun.
    pub fn trail(&self, bytes: &[u8], chain: usize, to: &mut Vec<i64>) {
        let found = self.trails.iter().find(|(of, _)| *of == chain);
        let found = found.and_then(|(_, place)| bytes.get(place.clone())).unwrap_or_default();
        to.extend(found.chunks_exact(8).map(bytemuck::pod_read_unaligned::<i64>));
        if to.first() == Some(&0) {
            to.clear();
        }
    }
}

/// The parts of a reaction with these stamps, [`PARTS`] for each node, into `parts`. Returns the designed waits among
/// them, ns: those for the release of a timer, or for another topic.
pub fn parts(trail: &[i64], parts: &mut Vec<i64>) -> i64 {
    parts.clear();
    let (mut reached_ns, mut designed_ns) = (trail[0], 0);
    for stamps in trail[1..].chunks_exact(STAMPS) {
        let [due, idle, start, end] = stamps else { continue };
        let sent_ns = reached_ns;
        // The source's release is the acquisition, however busy it is.
        let ready = if parts.is_empty() { due } else { due.max(idle) };
        let wait = part(&mut reached_ns, *ready);
        designed_ns += wait.min((due - sent_ns).max(0));
        parts.extend([wait, part(&mut reached_ns, *start), part(&mut reached_ns, *end)]);
    }
    designed_ns
}

/// The reactions of a chain.
pub struct Reactions {
    pub times: ChainTimes,
    /// Reaction times in each block of the run.
    pub blocks: Vec<Latencies>,
    /// Acquisition of the sample that the chain reacted to last, in whatever process, ns.
    last: Count,
    block_ns: i64,
    parts: Vec<i64>,
}

impl Reactions {
    pub fn open(graph: &Graph, chain: usize, group: &Group) -> Result<Self, RuntimeError> {
        let of = &graph.chains[chain];
        // A file has room for few histograms.
        let open =
            |name: &str| Figures::open(group, format!("chain{chain}.{name}"))?.latencies(name);
        let own = Figures::open(group, format!("chain{chain}"))?;
        let blocks = (0..BLOCKS).map(|block| open(&format!("block{block}")));
        let blocks = blocks.collect::<Result<_, _>>()?;
        let names: Vec<String> = (0..PARTS * of.path.len()).map(|part| part.to_string()).collect();
        let names = names.iter().map(String::as_str);
        let deadline_ns = of.deadline_ms.map_or(i64::MAX, |ms| ms.nanoseconds().cast_signed());
        let times = ChainTimes::open(names, deadline_ns, own.count("late")?, open)?;
        let block_ns = (graph.length_ns() / BLOCKS as i64).max(1);
        Ok(Self { times, blocks, last: own.count("last")?, block_ns, parts: Vec::new() })
    }

    /// Counts what ends at `end_ns` with these stamps: an age, and a reaction to a sample that is new. The run began at
    /// `start_ns`.
    pub fn count(&mut self, stamps: &[i64], (start_ns, end_ns): (i64, i64)) {
        let acquired_ns = stamps[0];
        self.times.age.record_ns(end_ns - acquired_ns);
        // One process at a time ends a chain.
        let newer = acquired_ns.cast_unsigned().wrapping_sub(self.last.get());
        if newer != 0 {
            self.last.add(newer);
            let designed_ns = parts(stamps, &mut self.parts);
            self.times.count(&self.parts, designed_ns);
            let block = ((end_ns - start_ns) / self.block_ns).clamp(0, BLOCKS as i64 - 1);
            self.blocks[block as usize].record_ns(end_ns - acquired_ns);
        }
    }
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
        let layout = Layout::of(&graph, "b");
        let mut bytes = vec![0; layout.length];
        let header = Header::new(7, 5, messages::Origins::NONE);
        let trails = [&[1, 2, 3, 4, 5, 6, 7, 8, 9][..], &[6, 6, 7, 8, 9]];
        layout.write(&mut bytes, &header, |chain| trails[chain]);
        assert_eq!(layout.read(&bytes).map(|header| header.step), Some(7));
        for (chain, stamped) in trails.into_iter().enumerate() {
            let mut found = Vec::new();
            layout.trail(&bytes, chain, &mut found);
            assert_eq!(found, stamped);
        }
        assert_eq!(Layout::of(&graph, "a").trails.len(), 1, "the second chain begins later");
        bytes[size_of::<Header>() + 3] ^= 1;
        assert!(layout.read(&bytes).is_none());
    }
}
