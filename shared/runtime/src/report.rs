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
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

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

/// Figures that a service can report: plain data of its own crate.
pub trait Reported: Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static {}

impl<T: Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static> Reported for T {}

/// Figures of one service, whose type only the service and the reader use.
///
/// In one process they stay the value that they are. Between processes they travel as JSON.
///
/// ```
/// use runtime::report::Payload;
///
/// let payload = Payload::of((7_u64, "late".to_owned()));
/// let line = serde_json::to_string(&payload)?;
/// let received: Payload = serde_json::from_str(&line)?;
/// for payload in [payload, received] {
///     assert_eq!(payload.read::<(u64, String)>(), Some((7, "late".to_owned())));
///     assert_eq!(payload.read::<bool>(), None);
/// }
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Payload(Form);

#[derive(Clone, Debug)]
enum Form {
    Value(Arc<dyn Carried>),
    Json(serde_json::Value),
}

/// [`Reported`] of any type.
trait Carried: Any + Debug + Send + Sync {
    fn json(&self) -> serde_json::Value;
    fn any(&self) -> &dyn Any;
}

impl<T: Reported> Carried for T {
    fn json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("figures are plain data")
    }

    fn any(&self) -> &dyn Any {
        self
    }
}

impl Payload {
    /// A payload of these figures.
    pub fn of(figures: impl Reported) -> Self {
        Self(Form::Value(Arc::new(figures)))
    }

    /// The figures, if they are of type `T`.
    pub fn read<T: Reported>(&self) -> Option<T> {
        match &self.0 {
            Form::Value(value) => (**value).any().downcast_ref::<T>().cloned(),
            Form::Json(json) => T::deserialize(json).ok(),
        }
    }

    fn json(&self) -> serde_json::Value {
        match &self.0 {
            Form::Value(value) => (**value).json(),
            Form::Json(json) => json.clone(),
        }
    }
}

impl PartialEq for Payload {
    fn eq(&self, other: &Self) -> bool {
        self.json() == other.json()
    }
}

impl Serialize for Payload {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.json().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Payload {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        serde_json::Value::deserialize(deserializer).map(|json| Self(Form::Json(json)))
    }
}
