//! Files that make no route, and programs that are no SUMO.

use std::fmt::Display;

/// A file of SUMO's that makes no road for the ego: its place, the fault, and the right form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ReadError(pub(crate) String);

impl ReadError {
    pub(crate) fn at(place: impl Display, reason: impl Display, expected: impl Display) -> Self {
        Self(format!("{place}: {reason}, expected {expected}"))
    }
}

impl From<openscenario::ReadError> for ReadError {
    fn from(error: openscenario::ReadError) -> Self {
        Self(error.to_string())
    }
}

/// A failure of the program SUMO, before or during a run, in one line.
#[derive(Debug, thiserror::Error)]
#[error("SUMO: {0}")]
pub struct ProgramError(pub(crate) String);

impl ProgramError {
    /// The system does not let it start.
    pub(crate) fn start(program: impl Display) -> impl Fn(std::io::Error) -> Self {
        move |reason| Self(format!("cannot start {program}: {reason}"))
    }

    pub(crate) fn silent(when: &str, waited_s: f64) -> Self {
        Self(format!("no answer {when} within {waited_s} s"))
    }

    pub(crate) fn refused(command: &str, words: &str) -> Self {
        Self(format!("{command} was refused: {words}"))
    }

    pub(crate) fn nonsense(fault: &str) -> Self {
        Self(format!("an answer that is not TraCI: {fault}"))
    }
}
