//! Settings of the road formulation.

use law::settings::{Settings, Table, within};
use scenario::Problem;

/// The table of the road formulation.
pub(super) const TABLE: Table = Table::of::<RoadConfig>("road");

law::settings! {
    /// Settings of the road formulation; all decelerations are positive numbers.
    pub struct RoadConfig {
        /// Gap that is never given up knowingly, m; from 0.1 to `standstill_distance_m`.
        min_gap_m: f64 = 2.0, "m", 0.1..=50.0, "Chosen.";
        /// Distance of the stop ahead of the line, m.
        stop_margin_m: f64 = 1.0, "m", 0.3..=20.0, "Chosen.";
        /// Largest acceleration, m/s²; from 0.2 to `max_request_mps2`.
        acceleration_mps2: f64 = 2.0, "m/s²", 0.2..=12.0, "Chosen.";
        /// Largest deceleration that still counts as comfortable, m/s²; from 0.5 to -`min_request_mps2`.
        comfort_deceleration_mps2: f64 = 3.0, "m/s²", 0.5..=12.0, "Chosen.";
        /// Deceleration that the reference driver aims at, m/s²; from 0.2 to `comfort_deceleration_mps2`.
        reference_deceleration_mps2: f64 = 1.7, "m/s²", 0.2..=12.0, "Chosen.";
        /// Hardest deceleration of the lead that the safety filter allows for, m/s². The gap grows beyond the time headway
        /// where that needs more (above 28 m/s with the defaults).
        lead_deceleration_mps2: f64 = 7.0, "m/s²", 0.5..=12.0, "Chosen.";
        /// Time constant with which the lead's acceleration is predicted to decay, s.
        lead_decay_s: f64 = 1.5, "s", 0.05..=20.0, "Chosen.";
        /// Reaction time in a stop for yellow, s. The line may be crossed in yellow if a stop from the end of green would
        /// end beyond it. The stop has this time and the comfort deceleration. 0: only if a stop begun at once would.
        yellow_reaction_s: f64 = 1.0, "s", 0.0..=2.0, "Chosen.";
        /// Weight `w` of the light's penalty `w/D` at each stage before the end of green, m. `D` is how far the line is
        /// passed then.
        light_weight_m: f64 = 1500.0, "m", 0.0..=1e6, "Chosen.";
        /// Margin `D` beyond which the light costs nothing, m. The default is that of the paper's formulation.
        light_threshold_m: f64 = 108.5, "m", 0.1..=1e3, "Chosen.";
        /// Once decided, the other program must be better by this share of its cost to be taken.
        hysteresis: f64 = 0.2, "1", 0.0..=10.0, "Chosen.";
        /// Weight on the gap error's distance from the reference, 1/m².
        gap_weight_per_m2: f64 = 0.2, "1/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the speed's distance from the reference, s²/m².
        speed_weight_s2_per_m2: f64 = 1.0, "s²/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the acceleration, s⁴/m².
        acceleration_weight_s4_per_m2: f64 = 0.1, "s⁴/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the jerk, s⁶/m².
        jerk_weight_s6_per_m2: f64 = 0.5, "s⁶/m²", 0.0..=1e6, "Chosen.";
        /// Weight on the request, s⁴/m².
        request_weight_s4_per_m2: f64 = 0.05, "s⁴/m²", 1e-6..=1e6, "Chosen.";
    }
}

impl Settings for RoadConfig {}

impl RoadConfig {
    /// Checks every setting, those included that depend on keys of `controller`. Keys are
    /// relative to `controller`.
    pub fn check_within(
        &self,
        (min_mps2, max_mps2): (f64, f64),
        standstill_m: f64,
    ) -> Result<(), Problem> {
        let comfort_mps2 = self.comfort_deceleration_mps2;
        within("road.min_gap_m", self.min_gap_m, 0.1, standstill_m)?;
        within("road.acceleration_mps2", self.acceleration_mps2, 0.2, max_mps2)?;
        within("road.comfort_deceleration_mps2", comfort_mps2, 0.5, -min_mps2)?;
        let reference_mps2 = self.reference_deceleration_mps2;
        within("road.reference_deceleration_mps2", reference_mps2, 0.2, comfort_mps2)?;
        self.check()
    }
}
