//! Damage of a recording.

use messages::Topic;
use std::fmt;
use std::path::PathBuf;

/// Reason why a file cannot be read as a recording at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It cannot be opened.
    #[error("cannot read {}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Cause by the system.
        reason: std::io::Error,
    },
    /// It is not a recording of timegap.
    #[error("{} is not a recording of timegap: {reason}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The missing part.
        reason: String,
    },
    /// Its messages have other layouts than this program's.
    #[error(
        "{} was recorded by {} with other messages (`{topic}` differs): read it with that \
         version", path.display(), program.escape_debug()
    )]
    Layout {
        /// The file.
        path: PathBuf,
        /// Program that recorded it.
        program: String,
        /// A topic whose schema differs.
        topic: String,
    },
}

/// A part of a recording that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Damage {
    /// The file ends before its end: the recorder was killed, or the disk was full.
    CutOff {
        /// Bytes behind the last whole record.
        bytes: u64,
    },
    /// The file goes on behind its end, as one to which another was appended.
    BehindEnd {
        /// Bytes behind the end.
        bytes: u64,
    },
    /// The summary behind the messages is damaged; its content comes from the messages instead.
    Summary {
        /// Its length, bytes.
        bytes: u64,
    },
    /// A chunk, or another record, is damaged and was left out.
    Chunk {
        /// Place in the file.
        offset: u64,
        /// Its length, bytes.
        bytes: u64,
        /// The damage.
        reason: String,
    },
    /// Parts of the file are too far from the order of log times. They were left out.
    Disorder {
        /// Their length, bytes.
        bytes: u64,
    },
    /// Messages of a topic that are not little-endian CDR of its type were left out.
    Payload {
        /// The topic.
        topic: Topic,
        /// Their number.
        messages: u64,
    },
    /// A topic of the file has the type of one of our topics, which the file lacks. Its messages were left out.
    Renamed {
        /// The topic.
        name: String,
        /// Ours.
        topic: Topic,
    },
    /// Behind its first messages the file declares another layout of a topic, whose messages were left out.
    Layout {
        /// The topic.
        topic: String,
    },
}

impl Damage {
    /// True where `timegap recording recover` writes a file without it.
    #[must_use]
    pub fn can_be_left_out(&self) -> bool {
        matches!(
            self,
            Self::CutOff { .. }
                | Self::BehindEnd { .. }
                | Self::Summary { .. }
                | Self::Chunk { .. }
        )
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CutOff { bytes: 0 } => f.write_str("the recording was never ended"),
            Self::CutOff { bytes } => {
                write!(
                    f,
                    "the recording was never ended; its last {bytes} bytes are not a whole part"
                )
            }
            Self::BehindEnd { bytes } => {
                write!(f, "{bytes} bytes behind the recording's end are left out")
            }
            Self::Summary { bytes } => {
                write!(
                    f,
                    "the summary of {bytes} bytes is damaged; the messages are read without it"
                )
            }
            Self::Chunk { offset, bytes, reason } => {
                write!(f, "{bytes} bytes from byte {offset} on are damaged ({reason})")
            }
            Self::Disorder { bytes } => write!(
                f,
                "{bytes} bytes are left out, and count as lost: the file is too far out of the order of log times, \
                 expected sorted by log time (`mcap sort`)"
            ),
            Self::Payload { topic, messages } => {
                let topic = topic.name();
                write!(
                    f,
                    "{messages} of the messages on `{topic}` are not as its type lays them out"
                )
            }
            Self::Renamed { name, topic } => write!(
                f,
                "the messages on `{}` are left out: their type is that of `{}`, expected under this name",
                name.escape_debug(),
                topic.name()
            ),
            Self::Layout { topic } => write!(f, "`{topic}` changes its type in the middle"),
        }
    }
}
