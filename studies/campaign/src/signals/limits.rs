//! Limits of the study. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-25 | excess trip time and missed greens of `cacc-mpc` over the rival's | 0.5 | chosen |

/// Largest share of the rival's figure that ours may be.
pub const OF_RIVAL: f64 = 0.5;
