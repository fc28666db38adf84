//! Counts and times that outlive the processes of a node, as the car's services keep theirs.

use crate::page::Page;
use crate::plan::Graph;
use crate::trail::{self, PARTS};
use runtime::chain::ChainTimes;
use runtime::statistics::Latencies;
use runtime::{Count, Group, Progress, RELEASE_JITTER, RuntimeError, ServiceCounts};

/// Blocks of equal length in a run. A gate compares two runs block by block.
pub const BLOCKS: usize = 12;
/// Histograms in one file of counts.
const IN_FILE: usize = 30;

/// Counts of a node over all its processes.
#[derive(Debug)]
pub struct NodeCounts {
    counts: ServiceCounts,
    pub cycles: Count,
    /// Releases that were left out, because the node was busy or stopped.
    pub skipped: Count,
    /// Start of a cycle after its release.
    pub jitter: Latencies,
    /// Start of a cycle to its end.
    pub work: Latencies,
}

fn of_node(node: usize) -> String {
    format!("node{node}")
}

impl NodeCounts {
    /// The counts of `node`. A process of it says which one it is.
    pub fn open(
        node: usize,
        incarnation: Option<u32>,
        group: &Group,
    ) -> Result<Self, RuntimeError> {
        let mut counts = ServiceCounts::open(group, of_node(node))?;
        incarnation.map(|incarnation| counts.begin_account(incarnation)).transpose()?;
        let figures = counts.figures();
        Ok(Self {
            cycles: figures.count("cycles")?,
            skipped: figures.count("skipped")?,
            jitter: figures.latencies(RELEASE_JITTER)?,
            work: figures.latencies("work")?,
            counts,
        })
    }

    /// The turns of the loop of process `incarnation`; `None` before it keeps an account.
    pub fn progress(node: usize, incarnation: u32, group: &Group) -> Option<Progress> {
        ServiceCounts::of(group, of_node(node)).progress(incarnation)
    }

    /// Shows others that this process lives.
    pub fn show_progress(&mut self, turns: u64) {
        self.counts.show_progress(turns);
    }

    pub fn cycle(&mut self, late_ns: i64, work_ns: i64) {
        self.cycles.add(1);
        self.jitter.record_ns(late_ns);
        self.work.record_ns(work_ns);
    }
}

/// Counts of a reader of a topic.
#[derive(Debug)]
pub struct ReaderCounts {
    pub received: Count,
    /// Messages that a newer one replaced before a cycle used them, here or in the transport's buffer.
    pub unused: Count,
    /// Messages that did not pass the end-to-end check, or were of a replaced process.
    pub refused: Count,
}

impl ReaderCounts {
    pub fn open(topic: usize, node: usize, group: &Group) -> Result<Self, RuntimeError> {
        let counts = ServiceCounts::open(group, format!("topic{topic}.node{node}"))?;
        let count = |name| counts.figures().count(name);
        Ok(Self {
            received: count("received")?,
            unused: count("unused")?,
            refused: count("refused")?,
        })
    }
}

/// Messages that were sent on a topic.
pub fn sent(topic: usize, group: &Group) -> Result<Count, RuntimeError> {
    ServiceCounts::open(group, format!("topic{topic}"))?.figures().count("sent")
}

/// The reactions of a chain.
#[derive(Debug)]
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
        let counts = |file| ServiceCounts::open(group, format!("chain{chain}.{file}"));
        let late = counts(0)?.figures().count("late")?;
        let mut opened = 0;
        let open = |name: &str| {
            opened += 1;
            counts((opened - 1) / IN_FILE)?.figures().latencies(name)
        };
        let names: Vec<String> = (0..PARTS * of.path.len()).map(|part| part.to_string()).collect();
        let deadline_ns = of.deadline_ns.unwrap_or(i64::MAX);
        let times = ChainTimes::open(names.iter().map(String::as_str), deadline_ns, late, open)?;
        let in_blocks = ServiceCounts::open(group, format!("chain{chain}.blocks"))?;
        let block = |block: usize| in_blocks.figures().latencies(&block.to_string());
        Ok(Self {
            times,
            blocks: (0..BLOCKS).map(block).collect::<Result<_, _>>()?,
            chain,
            block_ns: ((graph.duration_s * 1e9) as i64 / BLOCKS as i64).max(1),
            parts: Vec::with_capacity(names.len()),
        })
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
