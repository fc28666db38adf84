//! Numbers of the on-board unit that are not keys of a scenario, each with its origin.
//!
//! `cargo run --release -p obu --example unit_numbers` prints the effect of each number.
//!
//! ```
//! use obu::numbers::Numbers;
//!
//! // A line stays known longer than its unit needs for two maps.
//! assert!(Numbers::DEFAULT.map_silent_s > 2.0);
//! assert_eq!(Numbers::nanoseconds(2.0), 2_000_000_000);
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the on-board unit.
    pub struct Numbers {
        // Lanes.

        /// Half of a lane's width if the map has no width: half of 3.5 m.
        half_width_m: f64 = 1.75, "m", 1.25..=2.5, "Chosen: the lane of the simulated road. At 1.25 and 2.5 nothing changes.";
        /// Cosine of the largest angle between the lane and the vehicle: 30 degrees.
        same_way_cos: f64 = 0.866, "1", 0.5..=0.99, "Chosen: lanes of a crossing road differ by more. At 0.5 wrong line +259.3 s, line behind +19.7 s; at 0.99 no change.";

        // Intersections.

        /// Silence after which an intersection that is not ahead is dropped.
        forgotten_s: f64 = 30.0, "s", 5.0..=300.0, "Chosen: longer than a unit is out of sight behind a lorry. At 15 and 60 nothing changes.";
        /// Greatest age of the first map of an intersection: stop lines rarely move.
        oldest_map_s: f64 = 600.0, "s", 1.0..=3600.0, "Chosen: a map changes with works on the road, not within minutes. At 300 and 1200 nothing changes.";
        /// Greatest distance between the vehicle's path and a unit beside it.
        beside_path_m: f64 = 50.0, "m", 10.0..=200.0, "Chosen: units stand at the corners of an intersection. At 25 no change; at 100 wrong line +36.6 s, line behind +3.0 s.";
        /// Distance behind the vehicle at which a stop line is dropped.
        passed_m: f64 = 45.0, "m", 10.0..=100.0, "Chosen: less than the 50 m at which the unit beside it is dropped. At 22.5 line behind -10.5 s; at 90 line behind +21.0 s.";
        /// Time without a map after which a stop line is assumed: a unit sends its map once a second.
        map_due_s: f64 = 2.0, "s", 1.0..=10.0, "Chosen: one lost map is chance. At 1 wrong line +1.0 s; at 4 wrong line -2.0 s.";
        /// Distance from the assumed line to the unit: half of a large intersection.
        line_before_unit_m: f64 = 30.0, "m", 5.0..=60.0, "Chosen: a stop too early is safe, one too late is not. At 15 and 60 nothing changes.";

        // Contradictions.

        /// Silence of a map's sender after which another sender can replace the map.
        map_silent_s: f64 = 5.0, "s", 1.0..=30.0, "Chosen: four lost maps in a row are not chance. At 2.5 and 10 nothing changes.";
        /// Time for which a single message stands against another sender.
        once_stands_s: f64 = 2.0, "s", 0.5..=10.0, "Chosen: a real sender repeats its message within a second. At 1 right line with timing +1.0 s, right line without timing -1.0 s; at 4 right line with timing -2.0 s, right line without timing +2.0 s.";
        /// Largest difference between two announcements of the same end. Marks are tenths of a second, and a countdown
        /// slides a little.
        same_end_s: f64 = 0.35, "s", 0.1..=2.0, "Chosen: three marks of a tenth of a second. At 0.175 and 0.7 nothing changes.";

        // The service.

        /// Periods after which the timer releases a cycle without its batch.
        fallback_periods: f64 = 0.5, "periods", 0.1..=0.9, "Chosen: half of a period later the batch counts as lost. It acts in the service alone, which the example does not run.";
        /// Periods without a batch after which the radio counts as dead.
        dead_periods: u32 = 3, "periods", 1.0..=20.0, "Chosen: two lost batches are chance. It acts in the service alone.";
        /// Silence of a unit that was restarted during the run, in which it receives the maps of the intersections ahead.
        restart_silent_s: f64 = 1.3, "s", 0.0..=5.0, "Chosen: the period of a map, 1 s, and three batches. Meanwhile the controller uses the earlier timing. It acts in the service alone.";
    }
}

impl Numbers {
    /// A time in s as ns.
    #[must_use]
    pub fn nanoseconds(time_s: f64) -> i64 {
        (time_s * 1e9) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_whole_nanoseconds() {
        assert_eq!(Numbers::nanoseconds(Numbers::DEFAULT.restart_silent_s), 1_300_000_000);
        assert_eq!(Numbers::nanoseconds(Numbers::DEFAULT.once_stands_s), 2_000_000_000);
    }
}
