//! `part.json`: the study that a directory holds a part of.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use supervise::{Error, GroupOptions, UsageError};

use super::{FILE, Shard};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    schema_version: u32,
    pub study: String,
    /// What it asks.
    arguments: Value,
    /// Programs in the place of services.
    pub group: GroupOptions,
    /// Runs of the whole study.
    pub runs: usize,
    /// Checksum of the files that the arguments name: a file may have changed.
    subject: String,
    /// Part of the study; `None` is the whole.
    pub shard: Option<Shard>,
}

/// What a part's file is expected to be.
const EXPECTED: &str = "the description of a part";

impl PartFile {
    /// The part `shard` of a study with this number of runs, whose arguments name files with this content.
    pub fn new(
        study: &str,
        arguments: &impl Serialize,
        group: &GroupOptions,
        (runs, subject): (usize, &str),
        shard: Option<Shard>,
    ) -> Self {
        let subject = xxhash_rust::xxh3::xxh3_64(subject.as_bytes());
        // As it is read back: a number's last digit may differ.
        let text = serde_json::to_string(arguments).expect("arguments are plain data");
        Self {
            schema_version: 2,
            study: study.to_owned(),
            arguments: serde_json::from_str(&text).expect("it was written just now"),
            group: GroupOptions { processes: false, ..group.clone() },
            runs,
            subject: format!("{subject:016x}"),
            shard,
        }
    }

    /// Reads the file in a part's directory.
    pub fn read(directory: &Path) -> Result<Self, Error> {
        let path = directory.join(FILE);
        let error = |reason| Error::Path { action: "read", path: path.clone(), reason };
        let text = std::fs::read_to_string(&path).map_err(error)?;
        let part = serde_json::from_str(&text);
        Ok(part.map_err(|reason| UsageError::at(path.display(), reason, EXPECTED))?)
    }

    /// The file's text.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data") + "\n"
    }

    pub fn arguments<A: DeserializeOwned>(&self, directory: &Path) -> Result<A, UsageError> {
        let arguments = A::deserialize(&self.arguments);
        let place = || directory.join(FILE);
        arguments.map_err(|reason| UsageError::at(place().display(), reason, EXPECTED))
    }

    /// True if both are parts of one study.
    pub fn is_of_the_study_of(&self, other: &Self) -> bool {
        let count = |part: &Self| part.shard.map(|shard| shard.count);
        let shard = self.shard;
        *self == Self { shard, ..other.clone() } && count(self) == count(other)
    }
}

/// The command that continues the part in `directory`.
pub fn resume_command(directory: &Path) -> String {
    runtime::command_line(&["timegap", "resume", &directory.to_string_lossy()])
}
