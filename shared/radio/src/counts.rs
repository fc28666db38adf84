//! What a carrier counts.

use crate::clock::ClockComparison;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counters that the receive thread and the carrier's owner share.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(crate) sent: AtomicU64,
    pub(crate) not_sent: AtomicU64,
    pub(crate) received: AtomicU64,
    pub(crate) dropped: AtomicU64,
    pub(crate) malformed: AtomicU64,
}

/// What came of a carrier's frames, for results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RadioReport {
    /// The carrier's address.
    pub carrier: String,
    /// Frames handed to the network.
    pub sent: u64,
    /// Frames that could not be handed over: no link, no receiver yet, a full queue.
    pub not_sent: u64,
    /// Frames received, without repeats.
    pub received: u64,
    /// Frames received and not read in time: the queue to the loop was full.
    pub dropped: u64,
    /// Packets that are no frames: empty, too long, or with a broken envelope.
    pub malformed: u64,
    /// Each sender that was heard and says who it is.
    pub stations: Vec<StationReport>,
}

/// What came of one sender's frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationReport {
    /// Its number, in hexadecimal digits; drawn anew at each start.
    pub sender: String,
    /// Frames received.
    pub received: u64,
    /// Frames between the first and the last received that never came.
    pub lost: u64,
    /// Frames that came again.
    pub duplicates: u64,
    /// Frames that another overtook.
    pub reordered: u64,
    /// Frames that were not taken because their number was far from all others.
    #[serde(default)]
    pub implausible: u64,
    /// Its clock against this host's; null: it did not answer, so that the difference is unknown.
    pub clock: Option<ClockComparison>,
}

impl Counts {
    pub(crate) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn report(&self, carrier: String, stations: Vec<StationReport>) -> RadioReport {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        RadioReport {
            carrier,
            sent: read(&self.sent),
            not_sent: read(&self.not_sent),
            received: read(&self.received),
            dropped: read(&self.dropped),
            malformed: read(&self.malformed),
            stations,
        }
    }
}
