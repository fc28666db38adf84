//! Settings of the driver who stops at signals.

use scenario::schema::Schema;
use serde::{Deserialize, Serialize};

use crate::settings::{Ranges, Settings};

/// Settings of the driver who stops at signals; decelerations are positive numbers.
///
/// | key | source of its default |
/// |---|---|
/// | `sight_m` | MUTCD 2009, table 4D-2: a signal shall be visible from 140 m at 45 mph (20 m/s), less below |
/// | `reaction_s` | ITE (2020), *Guidelines for determining traffic signal change and clearance intervals*: 1.0 s |
/// | `yellow_deceleration_mps2` | the same: 10 ft/s², 3.05 m/s² |
/// | `stop_deceleration_mps2`, `stop_margin_m` | as `cacc-mpc`'s reference driver, so that only the rule differs |
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct SignalStop {
    /// Distance from the stop line at which the signal's colour is seen, m.
    pub sight_m: f64,
    /// Time from a change of colour to the driver's response, s.
    pub reaction_s: f64,
    /// Deceleration up to which a yellow or a new red is stopped for; beyond it the drive goes on, m/s².
    pub yellow_deceleration_mps2: f64,
    /// Deceleration that a stop aims at, m/s².
    pub stop_deceleration_mps2: f64,
    /// Distance of the stop ahead of the line, m.
    pub stop_margin_m: f64,
}

impl Default for SignalStop {
    fn default() -> Self {
        Self {
            sight_m: 150.0,
            reaction_s: 1.0,
            yellow_deceleration_mps2: 3.05,
            stop_deceleration_mps2: 1.7,
            stop_margin_m: 1.0,
        }
    }
}

impl Settings for SignalStop {
    fn ranges(&self, see: &mut Ranges<'_>) {
        see.within("sight_m", self.sight_m, 10.0, 1000.0);
        see.within("reaction_s", self.reaction_s, 0.0, 5.0);
        see.within("yellow_deceleration_mps2", self.yellow_deceleration_mps2, 0.5, 12.0);
        see.within("stop_deceleration_mps2", self.stop_deceleration_mps2, 0.2, 12.0);
        see.within("stop_margin_m", self.stop_margin_m, 0.3, 20.0);
    }
}
