//! Limits of the everyday scenes. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-26 | braking beyond which there is a need | 2.5 m/s² | chosen: the moderate stop of the gateway |
//! | 2026-11-21 | time from the need until the reference takes over | 0.35 s | UN R157, 5.2.5.2: the time in its formula for cut-ins |
//! | 2026-11-21 | braking of the reference beside the emergency brake | 6 m/s² | UN R157, 5.2.5.2: the deceleration in that formula |
//! | 2026-11-26 | braking with which no intervention was needed | 1.5 m/s² | chosen: half of the hardest braking that passengers accept |
//! | 2026-11-21 | avoidable contacts with the emergency brake | 0 | UN R157, 5.2.5.2 |
//! | 2026-11-26 | needless interventions | 0 | chosen |
//! | 2026-11-26 | share of drives with an avoidable contact without the emergency brake | 1 % | chosen |

use group::ReferenceDriver;

/// Braking beyond which there is a need, m/s².
pub const NEED_MPS2: f64 = ReferenceDriver::NEED_MPS2;
/// Time from the need until the reference takes over, s.
pub const REACTION_S: f64 = ReferenceDriver::REGULATION.reaction_s;
/// Braking of the reference beside the emergency brake, m/s².
pub const REFERENCE_MPS2: f64 = ReferenceDriver::REGULATION.deceleration_mps2;
/// Braking with which no intervention was needed, m/s².
pub const GENTLE_MPS2: f64 = 1.5;
/// Share of all drives with an avoidable contact without the emergency brake.
pub const ALONE_AT_MOST: f64 = 0.01;
