//! Reasons why a carrier does not carry. Errors of the runtime have them for causes.

use std::error::Error;
use std::io;

/// Refusal by a carrier of messages, or by a library or the system below it.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// A call of iceoryx2, whose errors are names.
    #[error("{0:?}")]
    Iceoryx2(Box<dyn Error + Send + Sync>),
    /// A call of the system.
    #[error("{what}: {reason}")]
    System {
        /// For what.
        what: &'static str,
        /// Its error.
        #[source]
        reason: io::Error,
    },
    /// The run's root is not a path for iceoryx2.
    #[error("the path is not UTF-8")]
    Path,
    /// The ids of iceoryx2's ports do not name their process.
    #[error("iceoryx2 does not name the process in its port ids as expected")]
    PortId,
    /// All members wait, one of them for room.
    #[error("a receiver does not read")]
    NotRead,
    /// There is no room, and the sender must not wait.
    #[error("a receiver's queue is full")]
    Full,
    /// The message was loaned from another carrier.
    #[error("a message of another carrier")]
    OtherCarrier,
    /// Bytes are played that no message of the topic has.
    #[error("{0} bytes are not such a message")]
    Length(usize),
}

impl TransportError {
    pub(crate) fn iceoryx2(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Iceoryx2(Box::new(error))
    }
}
