//! Counts and times that outlive the processes of a node, as the car's services keep theirs, and words that all share.

use crate::plan::{Graph, MOST};
use crate::trail::{self, PARTS};
use runtime::chain::ChainTimes;
use runtime::statistics::Latencies;
use runtime::{Count, Figures, Group, RELEASE_JITTER, RuntimeError, SharedWords};
use std::sync::atomic::{AtomicU32, Ordering};
use supervise::MachineError;

/// Blocks of equal length in a run. A gate compares two runs block by block.
pub const BLOCKS: usize = 12;
/// Words of a node.
const NODE: usize = 8;

/// The words that all processes of a graph share: wake-ups, epochs, the last reaction of each chain.
pub struct Page(SharedWords);

impl Page {
    pub fn map(group: &Group) -> Result<Self, MachineError> {
        const { assert!((NODE + 2) * MOST <= 1024, "a page has room for all") };
        let page = SharedWords::map(&format!("{}graph", group.prefix));
        page.map(Self).map_err(MachineError::cannot("share memory"))
    }

    /// Counts the messages that help to release a node.
    pub fn wake(&self, node: usize) -> &AtomicU32 {
        &self.0[NODE * node]
    }

    /// Incarnation of the one process of a node that may send.
    pub fn epoch(&self, node: usize) -> &AtomicU32 {
        &self.0[NODE * node + 1]
    }

    /// Notes that a chain reacts to the sample acquired at `acquired_ns`; false if it did before, in whatever process.
    fn reacts(&self, chain: usize, acquired_ns: i64) -> bool {
        let new = [(acquired_ns >> 32) as u32, acquired_ns as u32];
        // One process at a time ends a chain.
        let was = [0, 1]
            .map(|half| self.0[NODE * MOST + 2 * chain + half].swap(new[half], Ordering::Relaxed));
        was != new
    }
}

/// A named count of a topic, which all its ends share.
pub fn count(group: &Group, topic: &str, name: &str) -> Result<Count, RuntimeError> {
    Figures::open(group, format!("topic.{}", topic.replace('/', ".")))?.count(name)
}

/// Name of a node's counts.
pub fn counts_of(node: usize) -> String {
    format!("node{node}")
}

/// Counts of a node over all its processes.
pub struct NodeCounts {
    /// They show the turns of each process's loop.
    pub own: Figures,
    pub cycles: Count,
    /// Releases that were left out, because the node was busy or stopped.
    pub skipped: Count,
    /// Start of a cycle after its release.
    pub jitter: Latencies,
    /// Start of a cycle to its end.
    pub work: Latencies,
}

impl NodeCounts {
    /// The counts of a node; `node` is its place.
    pub fn open(node: usize, group: &Group) -> Result<Self, RuntimeError> {
        let own = Figures::open(group, counts_of(node))?;
        Ok(Self {
            cycles: own.count("cycles")?,
            skipped: own.count("skipped")?,
            jitter: own.latencies(RELEASE_JITTER)?,
            work: own.latencies("work")?,
            own,
        })
    }
}

/// The reactions of a chain.
pub struct Reactions {
    pub times: ChainTimes,
    /// Reaction times in each block of the run.
    pub blocks: Vec<Latencies>,
    chain: usize,
    block_ns: i64,
    parts: Vec<i64>,
}

impl Reactions {
    pub fn open(graph: &Graph, chain: usize, group: &Group) -> Result<Self, RuntimeError> {
        let of = &graph.chains[chain];
        // A file has room for few histograms.
        let open =
            |name: &str| Figures::open(group, format!("chain{chain}.{name}"))?.latencies(name);
        let late = Figures::open(group, format!("chain{chain}"))?.count("late")?;
        let blocks = (0..BLOCKS).map(|block| open(&format!("block{block}")));
        let blocks = blocks.collect::<Result<_, _>>()?;
        let names: Vec<String> = (0..PARTS * of.path.len()).map(|part| part.to_string()).collect();
        let deadline_ns = of.deadline_ns().unwrap_or(i64::MAX);
        let times = ChainTimes::open(names.iter().map(String::as_str), deadline_ns, late, open)?;
        let block_ns = graph.duration_s.nanoseconds().cast_signed() / BLOCKS as i64;
        Ok(Self { times, blocks, chain, block_ns: block_ns.max(1), parts: Vec::new() })
    }

    /// Counts what ends at `end_ns` with these stamps: an age, and a reaction to a sample that is new. The run began at
    /// `start_ns`.
    pub fn count(&mut self, stamps: &[i64], (start_ns, end_ns): (i64, i64), page: &Page) {
        self.times.age.record_ns(end_ns - stamps[0]);
        if page.reacts(self.chain, stamps[0]) {
            let designed_ns = trail::parts(stamps, &mut self.parts);
            self.times.count(&self.parts, designed_ns);
            let block = ((end_ns - start_ns) / self.block_ns).clamp(0, BLOCKS as i64 - 1);
            self.blocks[block as usize].record_ns(end_ns - stamps[0]);
        }
    }
}
