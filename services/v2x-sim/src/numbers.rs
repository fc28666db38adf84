//! Numbers of the roadside units and the map that are not keys of a scenario, each with its origin.
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
        map_period_s: f64 = 1.0, "s", 0.1..=10.0, "Chosen: the usual rate of roadside units.";
        /// Distance behind a stop line within which its unit still reaches the ego.
        passed_m: f64 = 50.0, "m", 0.0..=300.0, "Chosen: the middle of a large intersection and the ego's length.";
        /// Distance from the first stop line to the middle of an intersection.
        to_middle_m: f64 = 10.0, "m", 5.0..=40.0, "Chosen: an intersection of two roads with two lanes each.";
        /// Largest distance of a stop line from the reference point in a MAPEM.
        most_to_line_m: f64 = 327.0, "m", 1.0..=327.67, "Source: SAE J2735, Node-XY-32b: 16 bits of cm.";
        /// Length of a lane in a MAPEM.
        lane_m: f64 = 100.0, "m", 10.0..=300.0, "Chosen: receivers use the direction of a lane, not its length.";
        /// Width of a lane in a MAPEM.
        lane_width_m: f64 = 3.5, "m", 2.5..=5.0, "Chosen: the lane of the simulated road.";
        /// Length of the green that a contradicting unit announces.
        false_green_s: f64 = 30.0, "s", 1.0..=120.0, "Chosen: longer than the way of a car through the range of a unit.";
        /// Length of a cell of the map of curves.
        curve_cell_m: f64 = 25.0, "m", 5.0..=100.0, "Chosen: the 80 cells of a message cover 2 km; a cell is as long as the shortest clothoids of public roads.";
        /// Length of a cell of the map of grades.
        cell_m: f64 = 50.0, "m", 10.0..=200.0, "Chosen: the 48 cells of a message cover 2.4 km, more than a plan of 2 km.";
    }
}

/// The values in use.
pub static NUMBERS: Varied<Numbers> = Varied::new(Numbers::DEFAULT);
