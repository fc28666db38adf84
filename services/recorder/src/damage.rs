//! Damage of a recording.

use std::path::PathBuf;

/// Reason why a file cannot be read as a recording at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("cannot read {}: {reason}", path.display())]
    File { path: PathBuf, reason: std::io::Error },
    #[error("{} is not a recording of timegap: {reason}", path.display())]
    Foreign { path: PathBuf, reason: String },
    #[error(
        "{} was recorded by {} with other messages (`{topic}` differs): read it with that \
         version", path.display(), program.escape_debug()
    )]
    Layout { path: PathBuf, program: String, topic: String },
}

/// A part of a recording that could not be read. `timegap recording recover` writes a file without it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// The file ends before its end: the recorder was killed, or the disk was full.
    #[error("the recording was never ended{}", left_over(*bytes))]
    CutOff {
        /// Bytes behind the last whole record.
        bytes: u64,
    },
    /// The summary behind the messages is damaged; its content comes from the messages instead.
    #[error("the summary of {bytes} bytes is damaged; the messages are read without it")]
    Summary { bytes: u64 },
    /// A chunk, or another record, is damaged and was left out.
    #[error("{bytes} bytes from byte {offset} on are damaged ({reason})")]
    Chunk {
        /// Place in the file.
        offset: u64,
        bytes: u64,
        reason: String,
    },
}

fn left_over(bytes: u64) -> String {
    match bytes {
        0 => String::new(),
        bytes => format!("; its last {bytes} bytes are not a whole part"),
    }
}
