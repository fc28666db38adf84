//! Settings of the driver who stops at signals.

use parameters::parameters;
use scenario::schema::Schema;
use serde::{Deserialize, Serialize};

use law::settings::Settings;

parameters! {
    /// Settings of the driver who stops at signals; decelerations are positive numbers.
    #[derive(Serialize, Deserialize, Schema)]
    #[serde(deny_unknown_fields, default)]
    pub struct SignalStop {
        /// Distance from the stop line at which the signal's colour is seen, m.
        sight_m: f64 = 150.0, "m", 10.0..=1000.0,
            "Source: MUTCD 2009, table 4D-2: a signal shall be visible from 140 m at 45 mph (20 m/s), less below.";
        /// Time from a change of colour to the driver's response, s.
        reaction_s: f64 = 1.0, "s", 0.0..=5.0,
            "Source: ITE (2020), Guidelines for determining traffic signal change and clearance intervals: 1.0 s.";
        /// Deceleration up to which a yellow or a new red is stopped for; beyond it the drive goes on, m/s².
        yellow_deceleration_mps2: f64 = 3.05, "m/s²", 0.5..=12.0, "Source: ITE (2020), the same: 10 ft/s².";
        /// Deceleration that a stop aims at, m/s².
        stop_deceleration_mps2: f64 = 1.7, "m/s²", 0.2..=12.0,
            "Chosen: as `cacc-mpc`'s reference driver, so that only the rule differs.";
        /// Distance of the stop ahead of the line, m.
        stop_margin_m: f64 = 1.0, "m", 0.3..=20.0, "Chosen: as `cacc-mpc`'s reference driver.";
    }
}

impl Settings for SignalStop {}
