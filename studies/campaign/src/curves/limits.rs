//! Limits of the study. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! They hold for the sources of a course that drive by default: yaw rate, standing objects and trails.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-26 | lead lost, share of the time with a lead within 100 m | 0.5 % | chosen |
//! | 2026-11-26 | lead lost, times per km | 0.1 | chosen |
//! | 2026-11-26 | neighbour taken, times per km | 0.1 | chosen |
//! | 2026-11-26 | interventions of the emergency brake without a vehicle in the lane that needs one | 0 | chosen |
//! | 2026-11-26 | drives beside a queue with a request below -1.5 m/s² | 1 % | chosen |
//! | 2026-11-26 | collisions that 6 m/s² from sight avoids | 0 | chosen |
//! | 2026-11-26 | queues in the own lane that are the target later than 0.5 s after sight | 0 | chosen |

/// Largest share of the time with a lead within reach in which it may be lost.
pub const LOST_SHARE: f64 = 0.005;
/// Largest number of times per km that the lead may be lost.
pub const LOST_PER_KM: f64 = 0.1;
/// Largest number of times per km that a neighbour may be the target.
pub const TAKEN_PER_KM: f64 = 0.1;
/// Largest number of interventions of the emergency brake that nothing needs.
pub const PHANTOM_INTERVENTIONS: f64 = 0.0;
/// Request below which a drive beside a queue was braked, m/s².
pub const BRAKED_MPS2: f64 = -1.5;
/// Largest share of the drives beside a queue that may be braked.
pub const BRAKED_SHARE: f64 = 0.01;
/// Deceleration from sight that decides whether a collision was avoidable, m/s².
pub const FROM_SIGHT_MPS2: f64 = 6.0;
/// Largest number of avoidable collisions.
pub const AVOIDABLE_COLLISIONS: f64 = 0.0;
/// Time from sight to the target, s.
pub const SEEN_WITHIN_S: f64 = 0.5;
/// Largest number of queues that were seen later.
pub const SEEN_LATE: f64 = 0.0;
