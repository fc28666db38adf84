//! Numbers of the sensor model beside a scenario's keys, each with its origin.
//!
//! The keys of `[perception.radar.detections]` set the radar's strength and accuracy. These numbers set the reflections
//! of bodies and the receiver's noise. [`crate::tracking::numbers`] says how their effects were
//! measured.

use parameters::parameters;

parameters! {
    /// Numbers of the sensor model.
    pub struct Numbers {
        /// Share of a vehicle's mean cross section in the middle of its rear.
        rear_share: f64 = 0.6, "1", 0.1..=1.0, "Chosen. At 0.3 GOSPA +3 %; at 1 GOSPA -6 %.";
        /// Share in each rear corner.
        corner_share: f64 = 0.2, "1", 0.0..=0.5, "Chosen. At 0.1 GOSPA +3 %; at 0.4 GOSPA -4 %.";
        /// Share in each wheelhouse of a side that is seen squarely.
        side_share: f64 = 0.5, "1", 0.0..=1.0, "Chosen. At 0.25 GOSPA -3 %, cut-in delay +0.03 s; at 1 no change.";
        /// Distance of a wheelhouse from the end of the body.
        wheelhouse_m: f64 = 0.9, "m", 0.4..=1.5, "Chosen. At 0.45 cut-in delay +0.08 s; at 1.5 GOSPA +2 %, cut-in delay +0.08 s, time with a false target -17 %.";
        /// Longest stretch of a side without a place that reflects.
        side_spacing_m: f64 = 4.0, "m", 1.0..=8.0, "Chosen. At 2 GOSPA -3 %, time with a false target -42 %; at 8 GOSPA +18 %, time with a false target -48 %.";
        /// Length beyond which a vehicle is a lorry.
        longest_car_m: f64 = 7.0, "m", 5.5..=12.0, "Chosen. At 5.5 and 12 nothing changes.";
        /// Length of a stretch of road with or without a guard rail.
        rail_stretch_m: f64 = 100.0, "m", 10.0..=1000.0, "Chosen. At 50 no change; at 200 GOSPA -2 %, cut-in delay +0.03 s.";
        /// Depth of the strip beside the road in which objects stand.
        roadside_depth_m: f64 = 3.0, "m", 0.0..=20.0, "Chosen. At 1.5 GOSPA +6 %; at 6 GOSPA -7 %.";
        /// Power, in multiples of the noise, below which an echo is left out: noise alone is in the false alarms.
        least_power: f64 = 0.1, "1", 0.01..=1.0, "Chosen. At 0.05 no change; at 0.2 error of the ego's speed -15 %.";
        /// Largest range rate of a false alarm: the ambiguity limit of the waveform.
        largest_range_rate_mps: f64 = 70.0, "m/s", 30.0..=150.0, "Chosen. At 35 error of the ego's speed -54 %; at 140 no change.";
        /// False alarms in a scan beyond which the receiver raises its threshold.
        alarms_kept: f64 = 4.0, "alarms", 1.0..=20.0, "Chosen. At 2 and 8 nothing changes.";
    }
}
