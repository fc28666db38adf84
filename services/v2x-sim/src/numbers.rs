//! Numbers of the roadside units and the map that are not keys of a scenario, each with its origin.
//!
//! An origin ends with the effect of half and double the number, within the range. Signals and maps of lanes: `cacc-mpc`
//! on `corridor`, with frames and with units that contradict from 20 s on. Curves: `acc-mpc` on `curved-following` with
//! the map as a source of the course. Grades: `predictive` on `truck-hills`.
//!
//! ```sh
//! timegap test signals --effects v2x-sim --seeds 4 --set v2x.unit.contradicted_from_s=20
//! timegap test curves --effects v2x-sim --seeds 2 --only '+ map'
//! timegap test plausibility --effects v2x-sim --seeds 52 --only truck
//! ```
//!
//! ```
//! use v2x_sim::numbers::NUMBERS;
//!
//! // Two maps of a unit come within the time after which an on-board unit assumes a stop line.
//! assert!(2.0 * NUMBERS.map_period_s <= 2.0);
//! ```

use parameters::{Varied, parameters};

parameters! {
    /// Numbers of the roadside units and the map.
    pub struct Numbers {
        /// Time between two MAPEM of one unit.
        map_period_s: f64 = 1.0, "s", 0.1..=10.0, "Chosen: the usual rate of roadside units. At 0.5 and 2 nothing changes.";
        /// Distance behind a stop line within which its unit still reaches the ego.
        passed_m: f64 = 50.0, "m", 0.0..=300.0, "Chosen: the middle of a large intersection and the ego's length. At 25 and 100 nothing changes.";
        /// Distance from the first stop line to the middle of an intersection.
        to_middle_m: f64 = 10.0, "m", 5.0..=40.0, "Chosen: an intersection of two roads with two lanes each. At 5 and 20 nothing changes.";
        /// Largest distance of a stop line from the reference point in a MAPEM.
        most_to_line_m: f64 = 327.0, "m", 1.0..=327.67, "Source: SAE J2735, Node-XY-32b: 16 bits of cm. At 163.5 and 327.67 nothing changes.";
        /// Length of a lane in a MAPEM.
        lane_m: f64 = 100.0, "m", 10.0..=300.0, "Chosen: receivers use the direction of a lane, not its length. At 50 and 200 nothing changes.";
        /// Width of a lane in a MAPEM.
        lane_width_m: f64 = 3.5, "m", 2.5..=5.0, "Chosen: the lane of the simulated road. At 2.5 and 5 nothing changes.";
        /// Length of the green that a contradicting unit announces.
        false_green_s: f64 = 30.0, "s", 1.0..=120.0, "Chosen: longer than the way of a car through the range of a unit. At 15 rms jerk +159 %, stops +1.00, energy +117 %; at 60 no change.";
        /// Length of a cell of the map of curves.
        curve_cell_m: f64 = 25.0, "m", 5.0..=100.0, "Chosen: the 80 cells of a message cover 2 km; a cell is as long as the shortest clothoids of public roads. At 12.5 and 50 nothing changes.";
        /// Length of a cell of the map of grades.
        cell_m: f64 = 50.0, "m", 10.0..=200.0, "Chosen: the 48 cells of a message cover 2.4 km, more than a plan of 2 km. At 25 hardest braking -22 %, rms jerk -16 %, fuel -1.0 %; at 100 hardest braking -2 %, rms jerk -3 %, fuel +0.4 %.";
    }
}

/// The values in use.
pub static NUMBERS: Varied<Numbers> = Varied::new(Numbers::DEFAULT);
