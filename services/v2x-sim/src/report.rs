//! Figures that v2x-sim reports at its end, if the run's roadside units are on other hosts or in a capture.

pub use radio::{ClockComparison, StationReport};

use radio::RadioReport;
use serde::{Deserialize, Serialize};

/// Frames between the vehicle and other hosts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkReport {
    /// Counts of the carrier, and each sender that was received and names itself, vehicles too.
    #[serde(flatten)]
    pub radio: RadioReport,
    /// Frames among the received ones that came before the run began.
    pub before_start: u64,
    /// True if the true state of the signals is known: the unit runs the same scenario and sends when it began. Else
    /// the referee does not judge red lights.
    pub truth_known: bool,
}
