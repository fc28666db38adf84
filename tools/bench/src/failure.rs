//! The error of a measurement.

use std::error::Error;
use supervise::{Failure, Status};

/// A step that the machine did not allow, with its reason.
#[derive(Debug, thiserror::Error)]
#[error("the benchmark cannot {what}: {reason}")]
pub struct BenchError {
    what: &'static str,
    reason: Box<dyn Error + Send + Sync>,
}

impl Failure for BenchError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// The error of the step `what`, from its reason.
pub fn failed<E: Into<Box<dyn Error + Send + Sync>>>(
    what: &'static str,
) -> impl Fn(E) -> BenchError {
    move |reason| BenchError { what, reason: reason.into() }
}
