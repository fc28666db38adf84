//! A part under way, and `part.json`: the study that a directory holds a part of.

use super::begun::{Begun, SoFar};
use super::journal::Journal;
use super::{FILE, Line, Records, Shard, begun, holds, journal};
use crate::drives::Drive;
use report::output::OutputDirectory;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use supervise::{Error, GroupOptions, UsageError};

/// A part under way: its journal and what is left to do.
pub struct Part<T> {
    file: PartFile,
    journal: Journal,
    begun: Begun,
    so_far: BTreeMap<usize, SoFar>,
    /// The records so far.
    pub records: Records<T>,
}

impl<T: Serialize + DeserializeOwned> Part<T> {
    /// Begins a part in its directory, or continues the one that is there.
    pub fn open(file: PartFile, directory: &OutputDirectory) -> Result<Self, Error> {
        let place = directory.path();
        if !place.join(FILE).exists() {
            directory.write_input(FILE, file.text().as_bytes())?;
        } else if PartFile::read(place)? != file {
            let why = "it holds another study, or another part of it";
            return Err(UsageError::at(place.display(), why, "the one that it began with").into());
        }
        let mut records = Records::new(file.runs);
        records.begin(&place.join(journal::FILE));
        let mut each =
            |place, line: Line<T>| records.add(line.run, place, holds(file.shard, line.run));
        let journal = Journal::open(place, journal::FILE, &mut each)?;
        let (begun, mut so_far) = Begun::open(place)?;
        so_far.retain(|run, _| !records.has(*run));
        Ok(Self { file, journal, begun, so_far, records })
    }

    /// The file of runs that have begun, with what those of an earlier command had computed.
    pub(crate) fn take_begun(&mut self) -> (Begun, BTreeMap<usize, SoFar>) {
        (std::mem::take(&mut self.begun), std::mem::take(&mut self.so_far))
    }

    /// All runs have ended: what they had computed before is of no more use.
    pub(crate) fn end(&self, directory: &OutputDirectory) {
        begun::remove(directory.path());
    }

    /// A run that has not ended has kept values.
    pub(crate) fn has_begun(&self, directory: &OutputDirectory) -> bool {
        directory.path().join(begun::FILE).exists()
    }

    /// The runs of this part that are left to do.
    pub fn left(&self) -> Vec<usize> {
        self.mine().filter(|run| !self.records.has(*run)).collect()
    }

    fn mine(&self) -> impl Iterator<Item = usize> {
        (0..self.file.runs).filter(|run| holds(self.file.shard, *run))
    }

    /// Part of the study; `None` is the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.file.shard
    }

    pub fn runs(&self) -> usize {
        self.mine().count()
    }

    /// Keeps the record of a run with the figures of its drives.
    pub(crate) fn keep(&mut self, run: usize, result: T, drives: Vec<Drive>) -> Result<(), Error> {
        let place = self.journal.add(&Line { run, drives, result })?;
        self.records.add(run, place, true)
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    schema_version: u32,
    pub study: String,
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

/// The form that a part's file must have.
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
        let text = std::fs::read_to_string(&path).map_err(Error::path("read", &path))?;
        let part = serde_json::from_str(&text);
        Ok(part.map_err(|reason| UsageError::at(path.display(), reason, EXPECTED))?)
    }

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
