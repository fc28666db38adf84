//! The drive of one car, reduced to figures and a trace.

use serde::{Deserialize, Serialize};
use supervise::RequirementVerdict;
use supervise::report::{ControlFigures, Outcome};

use super::measure::Measured;
use super::wave::Amplitudes;

/// The drive of one car, reduced to figures and a trace.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Driven {
    /// Place of the car in the string, from 1.
    pub index: usize,
    pub controller: String,
    /// End of its drive.
    pub outcome: Outcome,
    pub requirements: Vec<RequirementVerdict>,
    pub figures: ControlFigures,
    /// Norms of its speeds and gaps.
    pub measured: Measured,
    /// Amplitudes behind a sine.
    pub amplitudes: Option<Amplitudes>,
    /// Time, s, position of its front bumper from the first car's start, m, and speed, m/s; empty
    /// behind a sine.
    pub trace: Vec<[f64; 3]>,
}
