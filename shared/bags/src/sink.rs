//! The hand-over from the readers of the formats.

use crate::BagError;

/// Encoding of the messages of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// CDR with a definition in ROS 2's language.
    Cdr,
    /// Serialised as in ROS 1, with its definition.
    Ros1,
    /// JSON text.
    Json,
    /// Another encoding, by name.
    Other(String),
}

/// A topic's declaration in a file.
pub(crate) struct Connection<'a> {
    pub(crate) id: u32,
    pub(crate) topic: &'a str,
    pub(crate) type_name: &'a str,
    pub(crate) definition: &'a str,
    pub(crate) encoding: Encoding,
}

/// Receiver of what a file holds.
pub(crate) trait Sink {
    /// A topic; the same one may come again.
    fn connection(&mut self, connection: Connection<'_>);
    /// A message of connection `id`.
    fn message(&mut self, id: u32, log_time_ns: u64, payload: &[u8]) -> Result<(), BagError>;
}
