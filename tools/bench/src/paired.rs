//! Comparisons of two ways to wake a process, in alternating blocks.
//!
//! A comparison has several sessions. In each, one source and one sink hold both ways open and use them in turn. Each
//! pair has a block of ours and a block of the floor in random order. Both processes get the
//! order with their job, so that they exchange only "ready" and "done".

use super::setup::{Conditions, FLAT_FROM, LARGEST, Mechanism};
use super::statistics::Pair;
use rand_core::Rng;
use rand_pcg::Pcg64;
use runtime::statistics::Latencies;
use schemars::JsonSchema;
use serde::Serialize;

/// Fewest pairs of blocks of a comparison.
pub const PAIRS: u32 = 20;
pub const PAIRS_IN_SESSION: u32 = 4;
/// Counted wake-ups in a block.
pub const WAKES: u32 = 250;
/// First wake-ups of a block, not counted: the other way has filled the caches.
pub const UNCOUNTED: u32 = 5;

/// Number of sessions of a comparison. Each has new processes, so that their memory is placed anew. All
/// comparisons take turns, so that each meets the machine at several times. Differences between sessions make
/// most of an interval: a full run makes three times as many.
pub const fn sessions(quick: bool) -> u32 {
    let fewest = PAIRS / PAIRS_IN_SESSION;
    if quick { fewest } else { 3 * fewest }
}

/// A comparison of a mechanism with its floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Comparison {
    /// The futex with itself: a control of the method.
    FloorItself,
    /// A message through the services' own ports with the futex.
    Message,
    /// The radar's detections with its tracks, both through the services' own ports.
    Detections,
    /// The largest payload with one of 4 KiB, both loaned and borrowed.
    Payload,
}

impl Comparison {
    /// All comparisons in the order of the results.
    pub const ALL: [Self; 4] = [Self::FloorItself, Self::Message, Self::Detections, Self::Payload];

    /// Names of the two sides, also in tags of histograms.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FloorItself => "futex over itself",
            Self::Message => "message over futex",
            Self::Detections => "radar detections over radar tracks",
            Self::Payload => "hand-over of 4 MiB over 4 KiB",
        }
    }

    /// Name in tables and goals.
    pub const fn label(self) -> &'static str {
        match self {
            Self::FloorItself => "control: futex against itself, should be 1.00",
            other => other.name(),
        }
    }

    pub const fn arms(self) -> [Mechanism; 2] {
        match self {
            Self::FloorItself => [Mechanism::Futex, Mechanism::Futex],
            Self::Message => [Mechanism::Message, Mechanism::Futex],
            Self::Detections => [Mechanism::Detections, Mechanism::Message],
            Self::Payload => [Mechanism::bare(LARGEST), Mechanism::bare(FLAT_FROM)],
        }
    }
}

/// The arm of each block, 0 for ours and 1 for the floor; each once in every pair.
pub fn order(pairs: u32, seed: u64) -> Vec<usize> {
    let mut random = Pcg64::new(seed.into(), 17);
    random.next_u64();
    let pair = |_| if random.next_u64() >> 63 == 0 { [0, 1] } else { [1, 0] };
    (0..pairs).flat_map(pair).collect()
}

pub fn paired(blocks: Vec<Vec<u32>>, order: &[usize]) -> Vec<Pair> {
    let mut blocks = blocks.into_iter().zip(order);
    let mut pairs = Vec::new();
    while let (Some((first, arm)), Some((second, _))) = (blocks.next(), blocks.next()) {
        let (ours, floor) = if *arm == 0 { (first, second) } else { (second, first) };
        pairs.push(Pair { ours, floor });
    }
    pairs
}

pub fn histogram<'a>(samples: impl Iterator<Item = &'a u32>) -> Latencies {
    let mut latencies = Latencies::default();
    samples.for_each(|ns| latencies.record_ns(i64::from(*ns)));
    latencies
}

#[derive(Clone, Debug)]
pub struct Compared {
    pub comparison: Comparison,
    pub conditions: Conditions,
    pub period_us: u32,
    pub lost: u64,
    /// The samples, session by session.
    pub pairs: Vec<Pair>,
}

impl Compared {
    /// Adds a later session of the same comparison.
    pub fn add(&mut self, session: Self) {
        self.lost += session.lost;
        self.pairs.extend(session.pairs);
    }

    pub fn sessions(&self) -> Vec<&[Pair]> {
        self.pairs.chunks(PAIRS_IN_SESSION as usize).collect()
    }

    /// All samples of ours and of the floor as histograms.
    pub fn histograms(&self) -> [Latencies; 2] {
        let of = |arm: fn(&Pair) -> &Vec<u32>| histogram(self.pairs.iter().flat_map(arm));
        [of(|pair| &pair.ours), of(|pair| &pair.floor)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order_of(seed: u64) -> Vec<usize> {
        order(40, seed)
    }

    #[test]
    fn every_pair_has_both_arms_in_an_order_drawn_by_lot() {
        let order = order_of(5);
        assert!(order.chunks(2).all(|pair| pair[0] + pair[1] == 1), "{order:?}");
        let ours_first = order.chunks(2).filter(|pair| pair[0] == 0).count();
        assert!((8..=32).contains(&ours_first), "{ours_first} of 40");
        assert_eq!(order, order_of(5), "the seed decides");
        assert_ne!(order, order_of(6));
    }

    #[test]
    fn blocks_find_their_arm_again() {
        let blocks = order_of(5).iter().map(|&arm| vec![arm as u32; 3]).collect();
        for pair in paired(blocks, &order_of(5)) {
            assert_eq!((pair.ours, pair.floor), (vec![0; 3], vec![1; 3]));
        }
    }

    #[test]
    fn enough_blocks_and_samples_for_a_99th_percentile() {
        const { assert!(PAIRS >= 20 && WAKES >= 250 && WAKES <= 500) };
        const { assert!(PAIRS_IN_SESSION * sessions(true) == PAIRS) };
        assert!((PAIRS * WAKES) as usize >= crate::statistics::ENOUGH_FOR_P99);
    }
}
