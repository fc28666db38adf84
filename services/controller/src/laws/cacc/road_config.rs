//! Settings of the road formulation.

use scenario::schema::Schema;
use serde::{Deserialize, Serialize};

use crate::settings::{Ranges, SettingError, Settings, Table, within};

/// The table of the road formulation.
pub(super) const TABLE: Table = Table::of::<RoadConfig>("road");

/// Settings of the road formulation; all decelerations are positive numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct RoadConfig {
    /// Desired gap to a standing lead, m.
    #[serde(skip)]
    pub standstill_gap_m: f64,
    /// Gap that is never given up knowingly, m; from 0.1 to `standstill_distance_m`.
    pub min_gap_m: f64,
    /// Distance of the stop ahead of the line, m.
    pub stop_margin_m: f64,
    /// Largest acceleration, m/s²; from 0.2 to `max_request_mps2`.
    pub acceleration_mps2: f64,
    /// Largest deceleration that still counts as comfortable, m/s²; from 0.5 to -`min_request_mps2`.
    pub comfort_deceleration_mps2: f64,
    /// Deceleration that the reference driver aims at, m/s²; from 0.2 to `comfort_deceleration_mps2`.
    pub reference_deceleration_mps2: f64,
    /// Hardest deceleration of the lead that the safety filter allows for, m/s². The gap grows beyond the time headway
    /// where that needs more (above 28 m/s with the defaults).
    pub lead_deceleration_mps2: f64,
    /// Time constant with which the lead's acceleration is predicted to decay, s.
    pub lead_decay_s: f64,
    /// Reaction time in a stop for yellow, s. The line may be crossed in yellow if a stop from the end of green would
    /// end beyond it. The stop has this time and the comfort deceleration. 0: only if a stop begun at once would.
    pub yellow_reaction_s: f64,
    /// Weight `w` of the light's penalty `w/D` at each stage before the end of green, m. `D` is how far the line is
    /// passed then.
    pub light_weight_m: f64,
    /// Margin `D` beyond which the light costs nothing, m. The default is that of the paper's formulation.
    pub light_threshold_m: f64,
    /// Once decided, the other program must be better by this share of its cost to be taken.
    pub hysteresis: f64,
    /// Weight on the gap error's distance from the reference, 1/m².
    pub gap_weight_per_m2: f64,
    /// Weight on the speed's distance from the reference, s²/m².
    pub speed_weight_s2_per_m2: f64,
    /// Weight on the acceleration, s⁴/m².
    pub acceleration_weight_s4_per_m2: f64,
    /// Weight on the jerk, s⁶/m².
    pub jerk_weight_s6_per_m2: f64,
    /// Weight on the request, s⁴/m².
    pub request_weight_s4_per_m2: f64,
}

impl Default for RoadConfig {
    fn default() -> Self {
        Self {
            standstill_gap_m: 5.0,
            min_gap_m: 2.0,
            stop_margin_m: 1.0,
            acceleration_mps2: 2.0,
            comfort_deceleration_mps2: 3.0,
            reference_deceleration_mps2: 1.7,
            lead_deceleration_mps2: 7.0,
            lead_decay_s: 1.5,
            yellow_reaction_s: 1.0,
            light_weight_m: 1500.0,
            light_threshold_m: 108.5,
            hysteresis: 0.2,
            gap_weight_per_m2: 0.2,
            speed_weight_s2_per_m2: 1.0,
            acceleration_weight_s4_per_m2: 0.1,
            jerk_weight_s6_per_m2: 0.5,
            request_weight_s4_per_m2: 0.05,
        }
    }
}

impl Settings for RoadConfig {
    fn ranges(&self, see: &mut Ranges<'_>) {
        see.within("stop_margin_m", self.stop_margin_m, 0.3, 20.0);
        see.within("lead_deceleration_mps2", self.lead_deceleration_mps2, 0.5, 12.0);
        see.within("lead_decay_s", self.lead_decay_s, 0.05, 20.0);
        see.within("yellow_reaction_s", self.yellow_reaction_s, 0.0, 2.0);
        see.within("light_weight_m", self.light_weight_m, 0.0, 1e6);
        see.within("light_threshold_m", self.light_threshold_m, 0.1, 1e3);
        see.within("hysteresis", self.hysteresis, 0.0, 10.0);
        see.within("gap_weight_per_m2", self.gap_weight_per_m2, 0.0, 1e6);
        see.within("speed_weight_s2_per_m2", self.speed_weight_s2_per_m2, 0.0, 1e6);
        let acceleration = self.acceleration_weight_s4_per_m2;
        see.within("acceleration_weight_s4_per_m2", acceleration, 0.0, 1e6);
        see.within("jerk_weight_s6_per_m2", self.jerk_weight_s6_per_m2, 0.0, 1e6);
        see.within("request_weight_s4_per_m2", self.request_weight_s4_per_m2, 1e-6, 1e6);
    }
}

impl RoadConfig {
    /// Checks every setting, those included that depend on the bounds of the request. Keys are
    /// relative to `controller`.
    ///
    /// # Errors
    /// The first key that is not usable.
    pub fn check_within(&self, min_mps2: f64, max_mps2: f64) -> Result<(), SettingError> {
        let (standstill_m, comfort_mps2) = (self.standstill_gap_m, self.comfort_deceleration_mps2);
        within("road.standstill_gap_m", standstill_m, 1.0, 50.0)?;
        within("road.min_gap_m", self.min_gap_m, 0.1, standstill_m)?;
        within("road.acceleration_mps2", self.acceleration_mps2, 0.2, max_mps2)?;
        within("road.comfort_deceleration_mps2", comfort_mps2, 0.5, -min_mps2)?;
        let reference_mps2 = self.reference_deceleration_mps2;
        within("road.reference_deceleration_mps2", reference_mps2, 0.2, comfort_mps2)?;
        self.check()
    }
}
