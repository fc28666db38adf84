//! The drive of one car of a string, reduced to figures and a trace.

use frame::batch::Done;
use group::RequirementVerdict;
use group::report::{ControlFigures, Outcome};
use scenario::Scenario;

use super::measure::{Measured, measure};
use super::scene::{Place, Plan};
use super::wave::Amplitudes;

/// Points of a trace, for the pictures.
const TRACE_POINTS: usize = 400;

/// The drive of one car.
#[derive(Clone, Debug)]
pub struct Driven {
    /// Its place in the string.
    pub place: Place,
    /// Its law.
    pub controller: String,
    /// End of its drive.
    pub outcome: Outcome,
    /// Verdicts on the requirements.
    pub requirements: Vec<RequirementVerdict>,
    /// Figures of the referee.
    pub figures: ControlFigures,
    /// Norms of its speeds and gaps.
    pub measured: Measured,
    /// Amplitudes behind a sine.
    pub amplitudes: Option<Amplitudes>,
    /// Time, s, position of its front bumper from the first car's start, m, and speed, m/s; empty
    /// behind a sine.
    pub trace: Vec<[f64; 3]>,
}

impl Driven {
    /// The drive of the car at `place`.
    pub fn of(plan: &Plan, place: Place, scenario: &Scenario, done: &Done) -> Self {
        let steps = &done.drive.steps;
        let trace = match plan.wave {
            Some(_) => Vec::new(),
            None => {
                let stride = steps.len().div_ceil(TRACE_POINTS).max(1);
                let last = steps.len().saturating_sub(1);
                let kept = steps.iter().enumerate().filter(|(k, _)| k % stride == 0 || *k == last);
                kept.map(|(_, step)| {
                    [step.time_s, step.position_m - place.behind_first_m, step.speed_mps]
                })
                .collect()
            }
        };
        Self {
            place,
            controller: done.summary.controller.clone(),
            outcome: done.summary.outcome,
            requirements: done.summary.requirements.clone(),
            figures: done.summary.control.figures.clone(),
            measured: measure(scenario, &done.drive),
            amplitudes: plan.wave.and_then(|wave| wave.amplitudes(&done.drive)),
            trace,
        }
    }
}
