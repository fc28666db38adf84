//! What can go wrong in a service's life.

use messages::Topic;
use std::path::PathBuf;

/// What a person can do about an error of the transport; its own reason is a name in iceoryx2's sources,
/// which `TIMEGAP_LOG` shows.
const HINT: &str =
    ": `timegap doctor` checks the machine, TIMEGAP_LOG=1 shows the library's own words";

/// Why a service cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// The group file is missing, unreadable or not one.
    #[error("group file {}: {reason}", path.display())]
    GroupFile {
        /// Where it was looked for.
        path: PathBuf,
        /// What the reader said.
        reason: String,
    },
    /// iceoryx2 could not create a node.
    #[error("cannot join the run's shared memory below {}{HINT}", root.display())]
    Node {
        /// Root of the run.
        root: PathBuf,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A topic could not be created or opened.
    #[error("cannot open topic `{}`{HINT}", topic.name())]
    Topic {
        /// The topic.
        topic: Topic,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A message could not be sent.
    #[error("cannot send on topic `{}`{HINT}", topic.name())]
    Send {
        /// The topic.
        topic: Topic,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A message could not be received.
    #[error("cannot receive on topic `{}`{HINT}", topic.name())]
    Receive {
        /// The topic.
        topic: Topic,
        /// What iceoryx2 said.
        reason: String,
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
    #[error("link to the launcher: {0}")]
    Link(String),
    /// A foreign program that computes for the service failed.
    #[error("{0}")]
    Program(String),
    /// The service's own set-up failed.
    #[error("{0}")]
    Setup(String),
}
