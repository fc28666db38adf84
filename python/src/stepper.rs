//! A run whose law is asked step by step, in the caller's thread: what a Gymnasium environment is made of.

use crate::answer;
use crate::errors::{RunError, raise};
use crate::question::Question;
use crate::run::Driven;
use crate::scenario::Scenario;
use controller::laws::external::Questions;
use pyo3::prelude::*;
use runtime::Sealing;
use std::time::Instant;
use supervise::in_process::{Advance, SteppedRun};

/// A run in progress.
#[pyclass(unsendable, module = "timegap._timegap")]
pub struct Stepper {
    scenario: scenario::Scenario,
    run: Option<SteppedRun>,
    is_over: bool,
    interventions: usize,
    questions: Questions,
    begun: Instant,
}

impl Stepper {
    /// Goes on to the next question; none when the run is over.
    fn advance(&mut self) -> PyResult<Option<Question>> {
        let Some(run) = &mut self.run else {
            return Err(RunError::new_err("the run is over and its results were taken"));
        };
        loop {
            let advance = run.advance();
            self.interventions = run.moment().drive.interventions();
            match advance.map_err(|error| raise(&error))? {
                Advance::Turn => {}
                Advance::Asked => return Ok(self.questions.question().map(Question::new)),
                Advance::Over => {
                    self.is_over = true;
                    return Ok(None);
                }
            }
        }
    }
}

#[pymethods]
impl Stepper {
    /// Brings the services up to their start.
    #[new]
    fn new(scenario: &Scenario) -> PyResult<Self> {
        let (scenario, questions, begun) =
            (scenario.0.clone(), Questions::default(), Instant::now());
        let own = Some(questions.clone());
        let run = SteppedRun::begin(&scenario, Sealing::Unsealed, own);
        let run = Some(run.map_err(|error| raise(&error))?);
        Ok(Self { scenario, run, is_over: false, interventions: 0, questions, begun })
    }

    /// The first question; none if the run ends without one.
    fn start(&mut self) -> PyResult<Option<Question>> {
        self.advance()
    }

    /// Answers the question, and goes on to the next one; none when the run is over.
    fn step(&mut self, answer: &Bound<'_, PyAny>) -> PyResult<Option<Question>> {
        let name = self.scenario.controller.name.as_str();
        self.questions.answer(answer::of(answer, name)?);
        self.advance()
    }

    /// Times that the emergency brake has begun to brake.
    fn interventions(&self) -> usize {
        self.interventions
    }

    /// The results of a run that is over, or that ends here.
    fn finish(&mut self) -> PyResult<Driven> {
        let Some(mut run) = self.run.take() else {
            return Err(RunError::new_err("the results were taken already"));
        };
        if !self.is_over {
            run.interrupt();
            while run.advance().map_err(|error| raise(&error))? != Advance::Over {}
        }
        let outcome = run.finish().map_err(|error| raise(&error))?;
        Ok(Driven::of(&self.scenario, outcome, self.begun, None))
    }
}
