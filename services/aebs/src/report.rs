//! Figures that the emergency brake reports at its end.

use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};

/// Figures of the loop of the emergency brake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AebsReport {
    /// Deadline after each scheduled release, µs.
    pub deadline_us: f64,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: u64,
    /// Time for objects and decision, on the wall clock in both modes.
    pub decide_us: Option<Percentiles>,
}
