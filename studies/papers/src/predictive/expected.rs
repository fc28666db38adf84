//! Expected figures of the truck, which the drives and the computed ones share.

use crate::row::{Tolerance, within};
use truck_model::Preset;

/// Fuel that the reconstruction gives for a preset: the baseline in L/100 km, then percent against it.
pub struct Reconstructed {
    pub preset: Preset,
    pub constant_speed: f64,
    /// In the order of `PLANNERS`.
    pub planners: [f64; 2],
    pub full_route: f64,
    /// Standard deviations of 2.5 and 4 km/h.
    pub humans: [f64; 2],
}

pub const RECONSTRUCTED: [Reconstructed; 2] = [
    Reconstructed {
        preset: Preset::Jh6At49T,
        constant_speed: 34.25,
        planners: [-5.05, -7.6],
        full_route: -7.8,
        humans: [1.6, 2.8],
    },
    Reconstructed {
        preset: Preset::Jh6At25T,
        constant_speed: 21.81,
        planners: [-2.15, -3.3],
        full_route: -3.4,
        humans: [2.1, 3.6],
    },
];

/// Planners against the reconstruction's, percentage points.
pub const PLAN_POINTS: Tolerance = within(
    0.3,
    "another implementation of a planner on a grid; the n = 2 scheme is given as a range 0.1 to 0.3 wide",
);

/// The paper's sentences.
pub const TEST: &str = "the test without other vehicles, at a set speed of 75 km/h";
pub const SKILLED: &str = "a skilled driver's fuel on the same road (about 22 L)";
