//! Studies in parts: split over machines, interrupted and continued, joined again.
//!
//! ```text
//! --shard I/N ─► part.json (the study)                ┐
//!                runs.jsonl (a line per finished run) ┴─► --merge ─► the result of one machine
//!                begun.jsonl (values of long runs that are not finished)
//! ```
//!
//! A part's directory names the command that it is a part of. So a merge can name missing runs with the command that
//! completes them, and refuses parts of different studies. The sample for process groups is drawn from the whole
//! study: it is the same in any number of parts.

mod begun;
mod journal;
mod merge;
mod part;
mod records;
mod shard;
mod words;

pub(crate) use begun::{Begun, SoFar};
pub use merge::MergeError;
pub(crate) use merge::{Merged, name_incomplete};
pub(crate) use part::{Part, holds, take};
pub use records::Records;
pub use shard::{ArrayJobError, Shard, ShardChoice};

use std::path::{Path, PathBuf};

use clap::{Args, FromArgMatches};
use group::{Error, Failure};
use serde::{Deserialize, Serialize};

use crate::drives::Drive;
use crate::keep::Keep;

/// Name of the file that describes a part.
pub const FILE: &str = "part.json";

/// Options of a study that can be done in parts.
#[derive(Clone, Debug, Default, Args)]
pub struct PartOptions {
    /// Do only part I of N of the runs; `auto` takes both numbers from the array job's environment, `auto/N` only I;
    /// `--merge` joins the parts
    #[arg(long, value_name = "I/N|auto")]
    pub shard: Option<ShardChoice>,
    /// Continue the study in this directory, or begin a new one there
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Join the parts in these directories
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "resume"])]
    pub merge: Vec<PathBuf>,
    /// Keep the trajectories of runs in trajectories.parquet: all, failures, or worst:N by the smallest gap
    #[arg(long, value_name = "WHICH", conflicts_with_all = ["resume", "merge"])]
    pub keep: Option<Keep>,
}

/// Options of runs, by their names: a merge drives none.
pub const OF_RUNS: [&str; 3] = ["programs", "ready_timeout", "processes"];

/// Reason why a directory is not the part that is asked for.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// Its command is not one of this version.
    #[error("{FILE} of the parts: {}", first_line(.0))]
    Arguments(#[source] clap::Error),
    /// It holds something else.
    #[error(
        "{} holds another study, or another part of it, expected the one that it began with",
        .0.display()
    )]
    OtherStudy(PathBuf),
    /// Its file cannot be understood.
    #[error("{}: {reason}, expected the description of a part", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// The mistake in it.
        #[source]
        reason: serde_json::Error,
    },
}

impl Failure for PartError {}

/// The message about wrong arguments, without the usage.
fn first_line(error: &clap::Error) -> String {
    let said = error.to_string();
    said.trim_start_matches("error: ").lines().next().unwrap_or_default().to_owned()
}

/// The study that a directory holds a part of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    schema_version: u32,
    /// Words of the command, from its name on, without the options for place and manner of the runs.
    pub words: Vec<String>,
    /// Runs of the whole study.
    pub runs: usize,
    /// Checksum of the files that the words name: a file may have changed.
    pub scenario: String,
}

/// A file `part.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartFile {
    pub study: Study,
    /// Part of the study; `None` is the whole.
    pub shard: Option<Shard>,
}

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line<T> {
    pub run: usize,
    /// True if its repetition in a process group gave the same bytes. `None`: it was not repeated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub same_in_processes: Option<bool>,
    /// Figures of its drives.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drives: Vec<Drive>,
    pub result: T,
}

impl Study {
    /// The arguments of its command.
    ///
    /// # Errors
    /// [`PartError::Arguments`] if another version of the command wrote it.
    pub fn arguments<A: Args + FromArgMatches>(&self) -> Result<A, PartError> {
        // The first word is the command's name, as a program's would be.
        let command = A::augment_args(clap::Command::new("timegap"));
        let read = command.try_get_matches_from(&self.words);
        read.and_then(|matches| A::from_arg_matches(&matches)).map_err(PartError::Arguments)
    }

    /// The study of this process's own command line; `subject` is the content of all that its words name.
    pub(crate) fn of_command(runs: usize, subject: &str) -> Self {
        Self::of(words::of_study(std::env::args_os().skip(1)), runs, subject)
    }

    /// The command that continues the part in `directory`.
    pub(crate) fn resume(&self, directory: &Path) -> String {
        let directory = directory.to_string_lossy().into_owned();
        let words = self.words.iter().take(1).cloned().chain(["--resume".into(), directory]);
        format!("timegap {}", runtime::command_line(&words.collect::<Vec<_>>()))
    }

    /// The same command as it is understood now.
    pub(crate) fn now(&self, runs: usize, subject: &str) -> Self {
        Self::of(self.words.clone(), runs, subject)
    }

    fn of(words: Vec<String>, runs: usize, subject: &str) -> Self {
        let scenario = xxhash_rust::xxh3::xxh3_64(subject.as_bytes());
        Self { schema_version: 1, words, runs, scenario: format!("{scenario:016x}") }
    }
}

/// The part that `--resume` continues, and its directory, where the command line names no study.
pub(crate) fn begun(options: &PartOptions) -> Option<Result<(PathBuf, PartFile), Error>> {
    let directory = options.resume.clone()?;
    let path = directory.join(FILE);
    let is_named = words::of_study(std::env::args_os().skip(1)).len() > 1;
    (!is_named && path.exists()).then(|| Ok((directory, read_file(&path)?)))
}

/// The study of the first directory to join, or of the directory to continue if it holds a part.
///
/// # Errors
/// If the directory's `part.json` cannot be read.
pub fn held(options: &PartOptions) -> Result<Option<Study>, Error> {
    let continued = options.resume.as_ref().filter(|directory| directory.join(FILE).exists());
    let directory = options.merge.first().or(continued);
    directory.map(|directory| Ok(read_file(&directory.join(FILE))?.study)).transpose()
}

/// Reads a file `part.json`.
pub(crate) fn read_file(path: &Path) -> Result<PartFile, Error> {
    let error = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(error)?;
    serde_json::from_str(&text)
        .map_err(|reason| PartError::Description { path: path.to_owned(), reason }.into())
}
