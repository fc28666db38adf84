//! A law that the caller of a run in one process computes. It is asked between two turns of the services.
//!
//! ```text
//!   control loop ── question ──► Questions ──► caller, between two rounds of turns
//!        ▲                                        │
//!        └────────── answer, or failure ◄─────────┘
//! ```
//!
//! The caller's code runs on the caller's own stack and in the caller's own thread. So an interpreter finds its stack
//! where it expects it, and an error of the law stays with the caller.

use super::record::{Bounds, Refused, accept, question};
use crate::law::ProgramReport;
use crate::law::{Hosted, HostedError, Input, Law, Output};
use bytemuck::Zeroable;
use messages::{LawAnswer, LawInput};
use runtime::Turns;
use scenario::Scenario;
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Duration;
use thiserror::Error;

/// The exchange between the control loop and the caller of its run.
///
/// ```
/// use controller::laws::external::Questions;
///
/// let questions = Questions::default();
/// assert!(questions.question().is_none(), "nothing was asked yet");
/// ```
#[derive(Clone, Debug, Default)]
pub struct Questions(Rc<Exchange>);

#[derive(Debug)]
struct Exchange {
    state: Cell<State>,
    question: RefCell<LawInput>,
    answer: RefCell<LawAnswer>,
    failure: RefCell<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Idle,
    Asked,
    Answered,
    Failed,
}

impl Default for Exchange {
    fn default() -> Self {
        Self {
            state: Cell::default(),
            question: RefCell::new(LawInput::zeroed()),
            answer: RefCell::new(LawAnswer::zeroed()),
            failure: RefCell::default(),
        }
    }
}

impl Questions {
    /// True while a question waits for its answer.
    pub fn is_open(&self) -> bool {
        self.0.state.get() == State::Asked
    }

    /// The question that waits for its answer.
    pub fn question(&self) -> Option<LawInput> {
        self.is_open().then(|| *self.0.question.borrow())
    }

    /// Answers the question. Its number need not be in the answer.
    pub fn answer(&self, answer: LawAnswer) {
        self.0.answer.replace(answer);
        self.0.state.set(State::Answered);
    }

    /// Says why the law has no answer. This ends the run.
    pub fn fail(&self, why: String) {
        self.0.failure.replace(why);
        self.0.state.set(State::Failed);
    }
}

/// Reasons why such a law does not go on.
#[derive(Debug, Error)]
enum AskedError {
    /// The run has no caller who could answer.
    #[error(
        "the law `{0}` is a function of the program that starts the run, expected a run in one process"
    )]
    NoCaller(String),
    /// No vehicle can follow the answer.
    #[error("the law `{0}` answered {1}")]
    Refused(String, String),
    /// The caller's own words.
    #[error("the law `{0}` failed: {1}")]
    Failed(String, String),
}

#[derive(Debug)]
pub struct Asked {
    name: String,
    questions: Questions,
    turns: Option<Turns>,
    bounds: Bounds,
    /// The law must clear its history.
    forget: bool,
    asked: u64,
    answers: u64,
}

impl Asked {
    /// The law that the scenario names. Without `turns` no reply is possible, and the run does not
    /// begin.
    pub(crate) fn new(questions: Questions, turns: Option<Turns>, scenario: &Scenario) -> Self {
        let controller = &scenario.controller;
        Self {
            name: controller.name.as_str().to_owned(),
            questions,
            turns,
            bounds: Bounds {
                least_mps2: controller.min_request_mps2.value(),
                most_mps2: controller.max_request_mps2.value(),
            },
            forget: true,
            asked: 0,
            answers: 0,
        }
    }

    fn ask(&mut self, input: &Input, output: &mut Output) -> Result<(), AskedError> {
        let no_caller = || AskedError::NoCaller(self.name.clone());
        let turns = self.turns.as_ref().ok_or_else(no_caller)?;
        self.asked += 1;
        let exchange = &self.questions.0;
        exchange.question.replace(question(input, self.asked, self.forget));
        exchange.state.set(State::Asked);
        self.forget = false;
        while exchange.state.get() == State::Asked {
            turns.wait();
        }
        if exchange.state.replace(State::Idle) == State::Failed {
            return Err(AskedError::Failed(self.name.clone(), exchange.failure.take()));
        }
        accept(&exchange.answer.borrow(), self.bounds, output)
            .map_err(|Refused(what)| AskedError::Refused(self.name.clone(), what))?;
        self.answers += 1;
        Ok(())
    }
}

impl Hosted for Asked {
    /// Asks nothing: the caller's law is first asked in the run.
    fn start(&mut self) -> Result<(), HostedError> {
        match self.turns {
            Some(_) => Ok(()),
            None => Err(HostedError::new(AskedError::NoCaller(self.name.clone()))),
        }
    }

    fn step_within(
        &mut self,
        _left: Option<Duration>,
        input: &Input,
        output: &mut Output,
    ) -> Result<(), HostedError> {
        self.ask(input, output).map_err(HostedError::new)
    }

    fn report(&self) -> ProgramReport {
        ProgramReport { answers: self.answers, ..ProgramReport::default() }
    }
}

impl Law for Asked {
    fn reset(&mut self) {
        self.forget = true;
    }

    /// As in a run; a failure leaves the output as it was.
    fn step(&mut self, input: &Input, output: &mut Output) {
        // The loop asks through `Hosted`, which hands the failure on.
        let _ = self.ask(input, output);
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        (self.bounds.least_mps2, self.bounds.most_mps2)
    }

    fn hosted(&mut self) -> Option<&mut dyn Hosted> {
        Some(self)
    }
}
