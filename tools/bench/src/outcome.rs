//! The outcome of a job.

use runtime::scheduling::Granted;
use runtime::statistics::Latencies;
use serde::{Deserialize, Serialize};

/// Measurements of a job.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    pub granted: Granted,
    pub latencies: Latencies,
    /// Scheduled releases or wake-ups.
    pub cycles: u64,
    /// Wake-ups that did not arrive one by one.
    pub misses: u64,
    /// Bytes copied between the sender's writing and the reader's reading.
    pub copied_bytes: u64,
}

impl Outcome {
    /// The outcome of a process without measurements of its own.
    pub fn of_cycles(granted: Granted, cycles: u64) -> Self {
        Self { granted, latencies: Latencies::default(), cycles, misses: 0, copied_bytes: 0 }
    }
}
