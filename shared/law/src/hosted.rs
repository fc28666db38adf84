//! A law that a foreign program computes: the control loop's requests to its host.

use super::{Input, Output};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::time::Duration;
use thiserror::Error;

/// Reason why a foreign law cannot go on. The sentence names the program and what was expected of it.
#[derive(Debug, Error)]
#[error(transparent)]
pub struct HostedError(Box<dyn std::error::Error + Send + Sync>);

impl HostedError {
    pub fn new(cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self(Box::new(cause))
    }
}

/// The host of a foreign law's program.
pub trait Hosted {
    /// The run is one of many in this thread: its program may serve them one after another.
    fn share(&mut self) {}

    /// Starts the program and waits for its first answer. A law without a program of its own has nothing to start.
    ///
    /// # Errors
    /// [`HostedError`] if the program does not answer, with its act.
    fn start(&mut self) -> Result<(), HostedError> {
        Ok(())
    }

    /// The run begins in real time: the program gets a share of the services' scheduling.
    fn begin_realtime(&mut self, scenario: &Scenario) {
        let _ = scenario;
    }

    /// One step of the law. `left` is the wall time for the answer. Without an answer by then the law's backup answers.
    /// None: in simulated time, which waits for the answer.
    ///
    /// # Errors
    /// In simulated time, when no answer comes, or a wrong one: its repetition would be another run.
    fn step_within(
        &mut self,
        left: Option<Duration>,
        input: &Input,
        output: &mut Output,
    ) -> Result<(), HostedError>;

    fn report(&self) -> ProgramReport;
}

/// Counts of the host of a foreign law's program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramReport {
    pub starts: u64,
    /// Questions that it answered in time.
    pub answers: u64,
    /// Releases at which its answer was not there in time: the law's backup drove.
    pub late: u64,
    /// Answers that no vehicle could follow: the law's backup drove.
    pub refused: u64,
    /// Releases at which there was no program to ask: the law's backup drove.
    pub absent: u64,
    /// Its failures, as many as the host keeps.
    pub failures: Vec<String>,
    /// It failed too often and was not started again.
    pub given_up: bool,
}
