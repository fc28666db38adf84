//! A position along one axis.

use crate::{STEP_S, VEHICLE_LENGTH_M};

/// A position along one axis: a start and the way since.
///
/// The way is the sum of the speeds of all steps times the step, not a sum of products. Rounding decides cases in which
/// two sides meet exactly at a step, and the reference rounds this sum.
#[derive(Clone, Debug)]
pub(crate) struct Travel {
    start_m: f64,
    speeds_mps: f64,
}

impl Travel {
    /// At `start_m`.
    pub(crate) fn from_m(start_m: f64) -> Travel {
        Travel { start_m, speeds_mps: 0.0 }
    }

    /// Start of steps that end at 0 and whose speeds sum up to `speeds_mps`.
    pub(crate) fn ending_at_0(speeds_mps: f64) -> Travel {
        Travel { start_m: 0.0, speeds_mps: -speeds_mps }
    }

    /// One step with `speed_mps`.
    pub(crate) fn step(&mut self, speed_mps: f64) {
        self.speeds_mps += speed_mps;
    }

    /// The position \[m\].
    pub(crate) fn position_m(&self) -> f64 {
        self.start_m + self.speeds_mps * STEP_S
    }

    /// Distance from the front bumper of a vehicle `behind` to this one's rear bumper \[m\].
    pub(crate) fn gap_to_m(&self, behind: &Travel) -> f64 {
        self.position_m() - behind.position_m() - VEHICLE_LENGTH_M
    }
}
