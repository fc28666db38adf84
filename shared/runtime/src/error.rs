//! Errors in a service's life.

use messages::Topic;
use scenario::{Problem, ScenarioError};
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

/// Advice for an error of the transport, whose own reason is a name in iceoryx2's sources.
const HINT: &str =
    ": `timegap doctor` checks the machine, TIMEGAP_LOG=1 shows the library's own words";

/// Reason why a service cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// iceoryx2 could not create a node below this root of the run.
    #[error("cannot join the run's shared memory below {root}{HINT}", root = .0.display())]
    Node(PathBuf, #[source] TransportError),
    /// A topic could not be opened, or a message not be sent or received.
    #[error("cannot {0} topic `{name}`{HINT}", name = .1.name())]
    Topic(&'static str, Topic, #[source] TransportError),
    /// In lockstep, the sample that is due in a step did not come in this wall time, s.
    #[error("waited {2:.1} s for `{name}` of step {1}, which never came", name = .0.name())]
    Starved(Topic, u64, f64),
    /// The launcher asked for an end while the service was waiting.
    #[error("stopped by the launcher")]
    Stopped,
    /// The service's standby has taken over: nothing that this process sends is used any more.
    #[error("replaced by the standby")]
    Replaced,
    /// A foreign program that computes for the service failed.
    #[error("{0}")]
    Program(#[source] Box<dyn Error + Send + Sync>),
    /// The scenario of the group file cannot be read.
    #[error("the scenario of the group file: {0}")]
    Scenario(#[from] ScenarioError),
    /// The scenario makes no such service.
    #[error("{}: {}", .0.path, .0.message)]
    Refused(#[from] Problem),
    /// Something that the service needs of the system is not to be had: a file of the run, the link to the launcher,
    /// shared memory, a thread.
    #[error("{0}: {1}")]
    Setup(String, #[source] io::Error),
}

impl RuntimeError {
    /// Without `what` the service cannot work.
    pub(crate) fn setup(what: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let what = what.into();
        move |reason| Self::Setup(what, reason)
    }

    /// The file at `path`, which all processes of the run read, is missing, unreadable or not one.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::setup(format!("group file {}", path.display()))
    }

    /// This part of the link to the launcher broke.
    pub(crate) fn link(what: &str) -> impl FnOnce(io::Error) -> Self {
        Self::setup(format!("link to the launcher: {what}"))
    }

    /// The carrier cannot do `what` with the topic.
    pub(crate) fn topic(what: &'static str, topic: Topic) -> impl FnOnce(TransportError) -> Self {
        move |reason| Self::Topic(what, topic, reason)
    }
}

/// Refusal by a carrier of messages, or by a library or the system below it.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// A call of iceoryx2, whose errors are names.
    #[error("{0:?}")]
    Iceoryx2(Box<dyn Error + Send + Sync>),
    /// A call of the system, for this.
    #[error("{0}: {1}")]
    System(&'static str, #[source] io::Error),
    /// The carrier cannot do it, for this reason.
    #[error("{0}")]
    Refused(&'static str),
}

impl TransportError {
    pub(crate) fn iceoryx2(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Iceoryx2(Box::new(error))
    }
}
