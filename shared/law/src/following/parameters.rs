//! Numbers of the car-following parts, each with its unit, range and origin.
//!
//! An origin ends with the effect of the number on `acc-mpc` in 16 everyday scenes without the emergency brake. These
//! are four cut-ins, stops, braking leads and cut-outs each. "No change" means less than 2 % of the least gap, the
//! hardest braking and the rms jerk, and no collision. Half and double are tried within the range, and otherwise 0.8
//! and 1.25 times.
//!
//! ```sh
//! timegap test everyday --effects following --controllers acc-mpc --seeds 4 --only alone \
//!     --only cut-in,stop,braking-lead,cut-out
//! ```
//!
//! The base: least gap 18.1 m, hardest braking 2.49 m/s², rms jerk 0.505 m/s³ (means of the scenes). There is no
//! collision. `six-mode` (20.4 m, 2.89 m/s², 0.479 m/s³) is named in the rows that change something there, and only in
//! them.

use parameters::{Varied, parameters};

parameters! {
    /// Numbers that keep a gap safe and end a stop softly.
    pub struct Following {
        /// Share of the hardest request that the vehicle surely reaches.
        sure_share: f64 = 0.95, "1", 0.5..=1.0,
            "Chosen: brakes on a dry road give at least as much. At 0.76: hardest braking +3 %, rms jerk +15 %; \
             `six-mode` -10 % and +3 %.";
        /// Deceleration from which a lead counts as braking.
        brakes_mps2: f64 = 1.5, "m/s²", 0.5..=3.0,
            "Chosen: what an engine and a slope give together; a tracker's noise is a third of it. No change at 0.75 \
             and 3.";
        /// Share that a braking lead may still add to its deceleration.
        may_add_share: f64 = 0.3, "1", 0.0..=1.0,
            "Chosen: what a tracker with a lag of 0.3 s misses of braking that sets in over 1 s. At 0.15: no change; \
             at 0.6: rms jerk +6 %.";
        /// Constant braking that is gentle; while it is enough, braking stays below twice this.
        gentle_mps2: f64 = 1.5, "m/s²", 0.5..=2.5,
            "Source: half of what passengers accept without a reason, 3 m/s² (ISO 15622: 3.5 at high speeds). No \
             change at 0.75 and 1.875; `six-mode` at 0.75: rms jerk -5 %.";
        /// Share of a gap below the smallest one that gentle braking must keep.
        kept_share: f64 = 0.7, "1", 0.3..=1.0,
            "Chosen: a car that pulls away uses up a tenth of the gap at most. At 0.35: rms jerk -7 %; at 0.875: no \
             change; `six-mode` at 0.35: rms jerk +3 %.";
        /// Missing gap at which the comfortable deceleration is asked for in full.
        missing_m: f64 = 5.0, "m", 1.0..=20.0, "Chosen: a car's length. No change at 2.5 and 10.";
        /// Fastest speed at which a stop is softened.
        fastest_soft_mps: f64 = 3.0, "m/s", 1.0..=6.0,
            "Chosen: the last second of a stop with 3 m/s². At 1.5: rms jerk -3 %; at 6: rms jerk -6 %.";
        /// Deceleration with which the last of the speed is lost.
        last_mps2: f64 = 0.03, "m/s²", 0.01..=0.2,
            "Chosen: below what a passenger feels, 0.05 m/s². No change at 0.015 and 0.06.";
        /// Request that holds a vehicle that stands.
        hold_mps2: f64 = -0.5, "m/s²", -2.0..=-0.1, "Chosen: holds on a slope of 5 %. No change at -0.25 and -1.";
        /// Requests below this mean to stop or to stay.
        stays_mps2: f64 = 0.1, "m/s²", 0.0..=0.5, "Chosen: twice what a passenger feels. No change at 0.05 and 0.2.";
        /// Speed below which such a request ends in standstill.
        creeps_mps: f64 = 0.3, "m/s", 0.1..=1.0,
            "Chosen: slower than a car creeps in its lowest gear, 1 m/s. No change at 0.15 and 0.6.";
        /// Speed below which the gentlest rate is taken whatever the room.
        last_mps: f64 = 0.15, "m/s", 0.05..=0.3,
            "Chosen: moves 0.15 m at the gentlest rate. No change at 0.075 and 0.3.";
    }
}

/// The values that the laws use.
pub static FOLLOWING: Varied<Following> = Varied::new(Following::DEFAULT);
