//! Limits of the goals, as ratios to the machine's floor. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-21 | futex against itself, p50 and p99 | 1.1, 1.5 | chosen; the true ratio is 1 |
//! | 2026-11-21 | message over futex, p50, same core and two cores | 1.3, 1.15 | chosen |
//! | 2026-11-21 | message over futex, p99 | 1.5 | chosen |
//! | 2026-11-21 | detections, payload, p50 | 1.2, 1.1 | chosen |
//! | 2026-11-21 | net reaction over the sum of its floors, p50 | 1.5 | chosen |
//! | 2026-11-21 | deadline misses over the floor's | 1 | no more than a process that sleeps and computes |

use super::paired::Comparison;
use super::setup::Placement;

/// Largest ratio of a chain's software overhead to the sum of its floors.
pub const CHAIN: f64 = 1.5;
/// Largest ratio of the deadline misses to the floor's.
pub const MISSES: f64 = 1.0;

/// Limits of a comparison: of the medians' ratio and, if judged, of the 99th percentiles' ratio.
pub fn of_comparison(comparison: Comparison, placement: Placement) -> (f64, Option<f64>) {
    match (comparison, placement) {
        // The true ratio is 1: excess up to here may be chance.
        (Comparison::FloorItself, _) => (1.1, Some(1.5)),
        (Comparison::Message, Placement::SameCore) => (1.3, Some(1.5)),
        (Comparison::Message, Placement::TwoCores) => (1.15, Some(1.5)),
        (Comparison::Detections, _) => (1.2, None),
        (Comparison::Payload, _) => (1.1, None),
    }
}
