//! Why a run has no result.

use group::report::Outcome;
use group::{Failure, Status};
use report::summary::Summary;

/// The machine cannot give what a run needs.
#[derive(Debug, thiserror::Error)]
#[error("cannot {what}: {cause}")]
pub struct PrepareError {
    what: &'static str,
    cause: std::io::Error,
}

impl PrepareError {
    /// An error from the system's.
    pub fn of(what: &'static str) -> impl Fn(std::io::Error) -> Self + Copy {
        move |cause| Self { what, cause }
    }
}

impl Failure for PrepareError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// A run did not reach its end.
#[derive(Debug, thiserror::Error)]
#[error("{scenario} with {controller}: {}", why.as_deref().unwrap_or("aborted"))]
pub struct Aborted {
    scenario: String,
    controller: String,
    /// The reason in its summary.
    why: Option<String>,
}

impl Failure for Aborted {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// Refuses a run that did not reach its end: it has no figures.
///
/// # Errors
/// [`Aborted`].
pub fn whole(summary: &Summary) -> Result<(), Aborted> {
    match (&summary.outcome, &summary.aborted_because) {
        (Outcome::Aborted, why) => Err(Aborted {
            scenario: summary.scenario.clone(),
            controller: summary.controller.clone(),
            why: why.clone(),
        }),
        _ => Ok(()),
    }
}
