//! Numbers of the on-board unit that are not keys of a scenario, each with its origin. One whose half and double change
//! nothing is a constant beside its use.
//!
//! `cargo run --release -p obu --example unit_numbers` prints the effect of each number.
//!
//! ```
//! use obu::numbers::Numbers;
//!
//! // A line is assumed when two maps in a row did not come.
//! assert_eq!(Numbers::DEFAULT.map_due_s, 2.0);
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the on-board unit.
    pub struct Numbers {
        // Lanes.

        /// Cosine of the largest angle between the lane and the vehicle: 30 degrees.
        same_way_cos: f64 = 0.866, "1", 0.5..=0.99, "Chosen: lanes of a crossing road differ by more. At 0.5 wrong line +259.3 s, line behind +19.7 s; at 0.99 no change.";

        // Intersections.

        /// Greatest distance between the vehicle's path and a unit beside it.
        beside_path_m: f64 = 50.0, "m", 10.0..=200.0, "Chosen: units stand at the corners of an intersection. At 25 no change; at 100 wrong line +36.6 s, line behind +3.0 s.";
        /// Distance behind the vehicle at which a stop line is dropped.
        passed_m: f64 = 45.0, "m", 10.0..=100.0, "Chosen: less than the 50 m at which the unit beside it is dropped. At 22.5 line behind -10.5 s; at 90 line behind +21.0 s.";
        /// Time without a map after which a stop line is assumed: a unit sends its map once a second.
        map_due_s: f64 = 2.0, "s", 1.0..=10.0, "Chosen: one lost map is chance. At 1 wrong line +1.0 s; at 4 wrong line -2.0 s.";

        // Contradictions.

        /// Time for which a single message stands against another sender.
        once_stands_s: f64 = 2.0, "s", 0.5..=10.0, "Chosen: a real sender repeats its message within a second. At 1 right line with timing +1.0 s, right line without timing -1.0 s; at 4 right line with timing -2.0 s, right line without timing +2.0 s.";
    }
}

pub(crate) fn nanoseconds(time_s: f64) -> i64 {
    (time_s * 1e9) as i64
}
