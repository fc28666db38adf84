//! Reasons why a bag gives no series.

use std::io;
use std::path::PathBuf;

/// Reason why a bag gives no series.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The file cannot be opened or read.
    #[error("it cannot be read: {0}")]
    File(#[from] io::Error),
    /// The file begins like no bag that is known.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    NoBag,
    /// A folder with several files.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    Folder {
        /// Number of bags in it.
        bags: usize,
        /// One of them.
        last: PathBuf,
    },
    /// A bag of ROS 2 that is an SQLite database, in a build without feature `sqlite`.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    Sqlite,
    /// A record is shorter than its stated lengths.
    #[error("a record in it is not whole")]
    Malformed,
    /// An SQLite database is damaged or is not a bag.
    #[error("its database cannot be read: {0}")]
    Database(String),
    /// A chunk cannot be unpacked.
    #[error("a chunk in it cannot be read: {0}")]
    Chunk(String),
    /// No topic has this name.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    NoTopic {
        /// The name.
        topic: String,
        /// Topics of the file.
        topics: Vec<String>,
    },
    /// The topic has no messages.
    #[error("no messages of topic `{0}`")]
    Empty(String),
    /// The topic's encoding is not read.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    Encoding {
        /// The topic.
        topic: String,
        /// Name of the encoding.
        encoding: String,
    },
    /// The messages have no such field, or it is not a number.
    #[error("{}, expected {}", self.message(), self.expected().unwrap_or_default())]
    NoField {
        /// Path of the field.
        field: String,
        /// Type of the messages.
        type_name: String,
        /// Numbers of the type.
        fields: Vec<String>,
    },
    /// A message is shorter than its definition.
    #[error("message {index} of topic `{topic}` does not fit its definition")]
    Message {
        /// The topic.
        topic: String,
        /// Number of the message, from 1.
        index: usize,
    },
    /// The topic has more messages than are read.
    #[error("topic `{topic}` has more than {most} messages")]
    TooMany {
        /// The topic.
        topic: String,
        /// Most messages.
        most: usize,
    },
}

impl BagError {
    /// The fault.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            Self::NoBag => "it is not a bag".to_owned(),
            Self::Folder { bags, .. } => format!("it is a folder with {bags} bags"),
            Self::Sqlite => "it is an SQLite bag".to_owned(),
            Self::NoTopic { topic, .. } => format!("no topic `{topic}`"),
            Self::Encoding { topic, encoding, .. } => {
                format!("topic `{topic}` is encoded as {encoding}")
            }
            Self::NoField { field, type_name, .. } => {
                format!("`{field}` is not a number of {type_name}")
            }
            other => other.to_string(),
        }
    }

    /// The right form, if it is known.
    #[must_use]
    pub fn expected(&self) -> Option<String> {
        Some(match self {
            Self::NoBag => "an MCAP file, a ROS 1 bag of version 2.0 or a ROS 2 bag".to_owned(),
            Self::Folder { last, .. } => format!("one of them, such as {}", last.display()),
            Self::Sqlite => "an MCAP file (`ros2 bag convert` makes one of it), or a build with \
                             `--features sqlite-bags`"
                .to_owned(),
            Self::NoTopic { topics, .. } => format!("one of {}", listed(topics)),
            Self::Encoding { .. } => "CDR (ros2msg), ROS 1 or JSON".to_owned(),
            Self::NoField { fields, .. } => format!("one of {}", listed(fields)),
            _ => return None,
        })
    }
}

/// Most names that an error lists.
const MOST_LISTED: usize = 30;

fn listed(names: &[String]) -> String {
    let quoted = names.iter().take(MOST_LISTED).map(|name| format!("`{name}`"));
    let rest = if names.len() > MOST_LISTED { ", …" } else { "" };
    match names {
        [] => "no name".to_owned(),
        _ => quoted.collect::<Vec<_>>().join(", ") + rest,
    }
}
