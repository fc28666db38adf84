//! Errors in a service's life.

use super::transport::TransportError;
use messages::Topic;
use scenario::{DecodeError, Problem};
use std::error::Error;
use std::io;
use std::path::PathBuf;

/// Advice for an error of the transport, whose own reason is a name in iceoryx2's sources.
const HINT: &str =
    ": `timegap doctor` checks the machine, TIMEGAP_LOG=1 shows the library's own words";

/// Reason why a service cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// The group file is missing, unreadable or not one.
    #[error("group file {}: {reason}", path.display())]
    GroupFile {
        /// The place that was searched.
        path: PathBuf,
        /// The reader's error.
        #[source]
        reason: io::Error,
    },
    /// iceoryx2 could not create a node.
    #[error("cannot join the run's shared memory below {}{HINT}", root.display())]
    Node {
        /// Root of the run.
        root: PathBuf,
        /// The transport's error.
        #[source]
        reason: TransportError,
    },
    /// A topic could not be opened, or a message not be sent or received.
    #[error("cannot {what} topic `{}`{HINT}", topic.name())]
    Topic {
        /// Request that failed.
        what: &'static str,
        /// The topic.
        topic: Topic,
        /// The transport's error.
        #[source]
        reason: TransportError,
    },
    /// In lockstep, a due sample did not come.
    #[error("waited {waited_s:.1} s for `{}` of step {step}, which never came", topic.name())]
    Starved {
        /// The topic.
        topic: Topic,
        /// Step in which the sample is due.
        step: u64,
        /// Wall time waited, s.
        waited_s: f64,
    },
    /// The launcher asked for an end while the service was waiting.
    #[error("stopped by the launcher")]
    Stopped,
    /// The service's standby has taken over: nothing that this process sends is used any more.
    #[error("replaced by the standby")]
    Replaced,
    /// The link to the launcher broke or carried nonsense.
    #[error("link to the launcher: {what}: {reason}")]
    Link {
        /// Part of it.
        what: &'static str,
        /// The system's error.
        #[source]
        reason: io::Error,
    },
    /// A foreign program that computes for the service failed.
    #[error("{0}")]
    Program(#[source] Box<dyn Error + Send + Sync>),
    /// A carrier of radio frames cannot be opened.
    #[error("radio: {0}")]
    Radio(#[source] Box<dyn Error + Send + Sync>),
    /// The scenario of the group file cannot be read.
    #[error("the scenario of the group file: {0}")]
    Scenario(#[from] DecodeError),
    /// The scenario makes no such service.
    #[error("{}: {}", .0.path, .0.message)]
    Refused(#[source] Box<Problem>),
    /// Something that the service needs of the system is not to be had.
    #[error("{what}: {reason}")]
    Setup {
        /// Request that failed.
        what: String,
        /// The system's error.
        #[source]
        reason: io::Error,
    },
}

impl RuntimeError {
    /// Without `what` the service cannot work.
    pub(crate) fn setup(what: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let what = what.into();
        move |reason| Self::Setup { what, reason }
    }
}

impl From<Problem> for RuntimeError {
    fn from(problem: Problem) -> Self {
        Self::Refused(Box::new(problem))
    }
}
