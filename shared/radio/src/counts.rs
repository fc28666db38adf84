//! Counts of a carrier.

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

/// Counts of a carrier's frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RadioReport {
    pub carrier: String,
    /// Frames passed to the network.
    pub sent: u64,
    /// Frames that could not be sent: no link, no receiver yet, a full queue.
    pub not_sent: u64,
    /// Frames received, without repeats.
    pub received: u64,
    /// Frames received and not read in time, because the queue to the loop was full.
    pub dropped: u64,
    /// Packets that are not frames: empty, too long, or with a broken envelope.
    pub malformed: u64,
    /// Senders that identify themselves.
    pub stations: Vec<StationReport>,
}

/// Counts of one sender's frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationReport {
    /// Number of the sender in hexadecimal digits, random at each start.
    pub sender: String,
    pub received: u64,
    /// Frames between the first and the last received one that did not arrive.
    pub lost: u64,
    /// Repeated frames.
    pub duplicates: u64,
    /// Frames that a later one overtook.
    pub reordered: u64,
    /// Frames refused for a number far from all others.
    #[serde(default)]
    pub implausible: u64,
    /// Its clock against this host's; absent without an answer.
    #[serde(flatten)]
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
