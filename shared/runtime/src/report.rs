//! Report of a service to the launcher at its end.
//!
//! The counts of ports, cycles and faults are the same for all services. A figure that only one service has
//! is defined by its own crate. It travels as a [`Payload`], which this crate does not look into.

mod payload;

pub use payload::{Payload, Reported};

use crate::FaultStatistics;
use crate::counts::statistics::Percentiles;
use crate::machine::scheduling::Granted;
use messages::Service;
use messages::e2e::Outcomes;
use serde::{Deserialize, Serialize};

/// Messages sent on a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SentTopic {
    /// Topic name.
    pub topic: String,
    /// Messages sent.
    pub sent: u64,
    /// XXH3 over the bytes of all messages in order, in lockstep.
    pub digest: Option<String>,
}

/// Messages received from a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReceivedTopic {
    /// Topic name.
    pub topic: String,
    /// Messages received.
    pub received: u64,
    /// Gaps in the sequence numbers.
    pub lost: u64,
    /// Outcomes of the end-to-end check.
    pub e2e: Outcomes,
}

/// Report of one service at its end, with the service's own figures as `D`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServiceReport<D = Payload> {
    /// The service.
    pub service: Service,
    /// Cycles run.
    pub cycles: u64,
    /// Releases that were left out because the service was busy or stopped.
    pub skipped: u64,
    /// Actual minus scheduled start of the cycles, realtime only.
    pub release_jitter_us: Option<Percentiles>,
    /// Topics published.
    pub sent: Vec<SentTopic>,
    /// Topics received.
    pub received: Vec<ReceivedTopic>,
    /// Allocations of the loop's thread between the start and the last cycle, where they are counted.
    /// Services that share a thread count each other's.
    pub allocations_in_loop: Option<u64>,
    /// Peak resident set of its process, KiB; `None` if it has no process of its own.
    pub peak_rss_kib: Option<u64>,
    /// Scheduling that the kernel granted.
    pub scheduling: Granted,
    /// Effects of faults on the service's messages.
    pub fault_statistics: Vec<FaultStatistics>,
    /// Figures that only this service has.
    pub details: D,
}

impl<D> ServiceReport<D> {
    /// The same report with its details as `read` makes them.
    pub fn map<E>(self, read: impl FnOnce(D) -> E) -> ServiceReport<E> {
        ServiceReport {
            service: self.service,
            cycles: self.cycles,
            skipped: self.skipped,
            release_jitter_us: self.release_jitter_us,
            sent: self.sent,
            received: self.received,
            allocations_in_loop: self.allocations_in_loop,
            peak_rss_kib: self.peak_rss_kib,
            scheduling: self.scheduling,
            fault_statistics: self.fault_statistics,
            details: read(self.details),
        }
    }
}
