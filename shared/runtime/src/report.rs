//! Report of a service to the launcher at its end.
//!
//! The counts of ports, cycles and faults are the same for all services. A figure that only one service has
//! is defined by its own crate. It travels as a [`Payload`], which this crate does not look into.

use crate::FaultStatistics;
use crate::counts::statistics::Percentiles;
use crate::machine::scheduling::Granted;
use messages::Service;
use messages::e2e::Outcomes;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Messages sent on a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SentTopic {
    pub topic: String,
    pub sent: u64,
    /// XXH3 over the bytes of all messages in order, in lockstep.
    pub digest: Option<String>,
}

/// Messages received from a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReceivedTopic {
    pub topic: String,
    pub received: u64,
    /// Gaps in the sequence numbers.
    pub lost: u64,
    pub e2e: Outcomes,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServiceReport {
    pub service: Service,
    pub cycles: u64,
    /// Releases that were left out because the service was busy or stopped.
    pub skipped: u64,
    /// Actual minus scheduled start of the cycles, realtime only.
    pub release_jitter_us: Option<Percentiles>,
    pub sent: Vec<SentTopic>,
    pub received: Vec<ReceivedTopic>,
    /// Allocations of the loop's thread between the start and the last cycle, where they are counted.
    /// Services that share a thread count each other's.
    pub allocations_in_loop: Option<u64>,
    /// Peak resident set of its process, KiB; `None` if it has no process of its own.
    pub peak_rss_kib: Option<u64>,
    pub scheduling: Granted,
    /// Effects of faults on the service's messages.
    pub fault_statistics: Vec<FaultStatistics>,
    /// Figures that only this service has.
    pub details: Payload,
}

/// Figures of one service as JSON, whose type only the service and the reader use. Null without any.
///
/// ```
/// use runtime::report::Payload;
///
/// let payload = Payload::of(&(7_u64, "late".to_owned()));
/// assert_eq!(payload.read::<(u64, String)>(), Some((7, "late".to_owned())));
/// assert_eq!(payload.read::<bool>(), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Payload(serde_json::Value);

impl Payload {
    /// A payload of these figures.
    ///
    /// # Panics
    /// If they are not plain data, with texts for the keys of maps.
    pub fn of(figures: &impl Serialize) -> Self {
        Self(serde_json::to_value(figures).expect("figures are plain data"))
    }

    /// The figures, if they are of type `T`.
    pub fn read<T: DeserializeOwned>(&self) -> Option<T> {
        T::deserialize(&self.0).ok()
    }
}
