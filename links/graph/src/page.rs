//! The words that all processes of a graph share: wake-ups, epochs, the last reaction of each chain.

use crate::file::MOST;
use runtime::{Group, SharedWords};
use std::sync::atomic::{AtomicU32, Ordering};
use supervise::MachineError;

/// Words of a node.
const NODE: usize = 8;

#[derive(Debug)]
pub struct Page(SharedWords);

impl Page {
    /// The page of the run of `group`.
    pub fn map(group: &Group) -> Result<Self, MachineError> {
        const { assert!((NODE + 2) * MOST <= 1024, "a page has room for all") };
        let page = SharedWords::map(&format!("{}graph", group.prefix));
        page.map(Self).map_err(MachineError::cannot("share memory"))
    }

    /// Counts the messages that help to release a node.
    pub fn wake(&self, node: usize) -> &AtomicU32 {
        self.0.word(NODE * node)
    }

    /// Incarnation of the one process of a node that may send.
    pub fn epoch(&self, node: usize) -> &AtomicU32 {
        self.0.word(NODE * node + 1)
    }

    /// Notes that a chain reacts to the sample acquired at `acquired_ns`; false if it did before, in whatever process.
    pub fn reacts(&self, chain: usize, acquired_ns: i64) -> bool {
        let word = |half: usize| self.0.word(NODE * MOST + 2 * chain + half);
        let [high, low] = [(acquired_ns >> 32) as u32, acquired_ns as u32];
        let was = [0, 1].map(|half| word(half).load(Ordering::Relaxed));
        // One process at a time ends a chain.
        word(0).store(high, Ordering::Relaxed);
        word(1).store(low, Ordering::Relaxed);
        was != [high, low]
    }
}
