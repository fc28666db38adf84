//! Studies in parts: on many machines, interrupted and gone on with, put together again.
//!
//! ```text
//! --shard I/N ─► part.json (what is studied)      ┐
//!                runs.jsonl (a line per finished run) ┴─► --merge ─► the result of one machine
//! ```
//!
//! A part's directory says which command it is a part of, so that a merge can name what is missing with
//! the command that completes it, and refuses what does not belong together. The runs that are repeated
//! in process groups are chosen of the whole study, so that they are the same ones in any number of parts.

pub mod journal;
mod merge;
mod shard;
mod words;

pub use merge::{Incomplete, MergeError, Merged, incomplete, name_incomplete, refuse_into_part};
pub use shard::{ArrayJobError, Shard, ShardChoice};

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, FromArgMatches};
use group::{Error, Failure};
use indicatif::ProgressBar;
use report::output::{OutputDirectory, OutputOptions};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::batch::{ProcessesSample, Repetition};
use journal::{Journal, JournalError};

/// What a part is a part of.
pub const FILE: &str = "part.json";

/// Options of a study that can be done in parts.
#[derive(Clone, Debug, Default, Args)]
pub struct PartOptions {
    /// Do only part I of N of the runs, or the part that the array job's environment names (`auto`,
    /// or `auto/N` where that does not give the number); `--merge` joins the parts
    #[arg(long, value_name = "I/N|auto")]
    pub shard: Option<ShardChoice>,
    /// Continue the study in this directory; begin it there if there is none
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Join the parts in these directories
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "resume"])]
    pub merge: Vec<PathBuf>,
}

/// Words that say how runs are driven, of which a merge drives none.
pub const OF_RUNS: [&str; 3] = ["programs", "ready_timeout", "processes"];

/// Why a directory is not the part that is asked for.
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
        /// What is wrong with it.
        #[source]
        reason: serde_json::Error,
    },
}

impl Failure for PartError {}

/// What is wrong with arguments, without the usage.
fn first_line(error: &clap::Error) -> String {
    let said = error.to_string();
    said.trim_start_matches("error: ").lines().next().unwrap_or_default().to_owned()
}

/// The study that a directory holds a part of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    schema_version: u32,
    /// Words of the command, from its name on; without the options that say where and how it runs.
    pub words: Vec<String>,
    /// Runs of the whole study.
    pub runs: usize,
    /// Checksum of the first run's scenario, which a file may have changed.
    pub scenario: String,
}

/// A file `part.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartFile {
    pub study: Study,
    /// Which part; none: the whole.
    pub shard: Option<Shard>,
}

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line<T> {
    pub run: usize,
    /// Whether its repetition in a process group gave the same bytes, if there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub same_in_processes: Option<bool>,
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

    /// The study of this process's own command line.
    pub fn of_this_command(runs: usize, first: &scenario::Scenario) -> Self {
        Self::of(words::of_study(std::env::args_os().skip(1)), runs, first)
    }

    fn of(words: Vec<String>, runs: usize, first: &scenario::Scenario) -> Self {
        let scenario = xxhash_rust::xxh3::xxh3_64(first.to_toml().as_bytes());
        Self { schema_version: 1, words, runs, scenario: format!("{scenario:016x}") }
    }
}

/// A part under way: its journal and what is left to do.
pub struct Part<T> {
    shard: Option<Shard>,
    study: Study,
    journal: Option<Journal>,
    /// What every finished run gave, by its number.
    results: Vec<Option<T>>,
    sample: ProcessesSample,
}

impl<T: Serialize + DeserializeOwned> Part<T> {
    /// Opens the directory of a part, or of the whole study. Without any of the options nothing is
    /// written of the runs before the end.
    ///
    /// # Errors
    /// [`ArrayJobError`], [`PartError`], [`JournalError`], or a file cannot be read or written.
    pub fn open(
        options: &PartOptions,
        output: &OutputOptions,
        study: Study,
    ) -> Result<(Self, OutputDirectory), Error> {
        let shard = options.shard.map(ShardChoice::resolve).transpose()?;
        let name = study.words.first().cloned().unwrap_or_default();
        let directory = match &options.resume {
            Some(path) => OutputDirectory::resume(path, FILE)?,
            None => OutputDirectory::create(output, &name)?,
        };
        let mut part = Self {
            shard,
            journal: None,
            results: std::iter::repeat_with(|| None).take(study.runs).collect(),
            sample: ProcessesSample::default(),
            study,
        };
        if shard.is_some() || options.resume.is_some() {
            part.begin(&directory)?;
        }
        Ok((part, directory))
    }

    fn begin(&mut self, directory: &OutputDirectory) -> Result<(), Error> {
        let path = directory.path().join(FILE);
        let own = PartFile { study: self.study.clone(), shard: self.shard };
        if path.exists() {
            if read_file(&path)? != own {
                return Err(PartError::OtherStudy(directory.path().to_owned()).into());
            }
        } else {
            let text = serde_json::to_string_pretty(&own).expect("plain data") + "\n";
            directory.write(FILE, text.as_bytes())?;
        }
        let mut each = |_, line| Ok(self.take(directory.path(), line)?);
        let journal = Journal::open::<Line<T>>(directory.path(), &mut each)?;
        self.journal = Some(journal);
        Ok(())
    }

    /// Takes a line of a journal.
    fn take(&mut self, directory: &Path, line: Line<T>) -> Result<(), JournalError> {
        let Line { run, same_in_processes, result } = line;
        let path = || directory.join(journal::FILE);
        match self.results.get_mut(run) {
            Some(slot @ None) if self.shard.is_none_or(|shard| shard.holds(run)) => {
                *slot = Some(result);
                let repetition = same_in_processes.map(Repetition::of_same);
                self.sample.count(run, repetition.as_ref());
                Ok(())
            }
            Some(Some(_)) => Err(JournalError::Twice { path: path(), run }),
            _ => Err(JournalError::OtherPart { path: path(), run }),
        }
    }

    /// The runs of this part that are left to do.
    pub fn left(&self) -> Vec<usize> {
        let mine = |run: &usize| self.shard.is_none_or(|shard| shard.holds(*run));
        (0..self.study.runs).filter(mine).filter(|run| self.results[*run].is_none()).collect()
    }

    /// Which part it is; none: the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// Runs of this part.
    pub fn runs(&self) -> usize {
        (0..self.study.runs).filter(|run| self.shard.is_none_or(|shard| shard.holds(*run))).count()
    }

    /// Those of `left` that are chosen to be repeated in process groups, by their places in it.
    pub fn repeated(&self, left: &[usize], seed: u64) -> BTreeSet<usize> {
        let chosen = crate::batch::choose(seed, self.study.runs);
        (0..left.len()).filter(|place| chosen.contains(&left[*place])).collect()
    }

    /// Keeps what a run gave.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub fn keep(
        &mut self,
        run: usize,
        result: T,
        repetition: Option<&Repetition>,
    ) -> Result<(), Error> {
        let same_in_processes = repetition.map(|repetition| *repetition == Repetition::Same);
        let line = Line { run, same_in_processes, result };
        if let Some(journal) = &mut self.journal {
            journal.add(&line)?;
        }
        self.sample.count(run, repetition);
        self.results[run] = Some(journal::as_read_back(&line).result);
        Ok(())
    }

    /// Says what came of the runs that were done of this part, `count` of them: of those that were repeated in
    /// process groups, or, if they ended early, how to go on.
    ///
    /// # Errors
    /// What ended them early.
    pub fn finish(
        &self,
        end: Result<ProcessesSample, Error>,
        count: usize,
        bar: &ProgressBar,
        directory: &OutputDirectory,
    ) -> Result<(), Error> {
        if let Ok(sample) = &end {
            sample.print(count, bar);
        }
        bar.finish_and_clear();
        if end.is_err() {
            self.print_how_to_continue(directory);
        }
        end.map(|_| ())
    }

    /// Prints the command that continues runs which ended early.
    fn print_how_to_continue(&self, directory: &OutputDirectory) {
        if self.journal.is_some() {
            let done = self.results.iter().flatten().count();
            let (all, command) = (self.runs(), runtime::command_line(&self.study.words));
            let shard = self
                .shard
                .map_or_else(String::new, |shard| format!(" --shard {}", String::from(shard)));
            let path = directory.path().display();
            eprintln!(
                "{done} of {all} runs are kept; to continue: timegap {command}{shard} --resume {path}"
            );
        }
    }

    /// What the runs gave, by their numbers, and what came of the repeated ones.
    pub fn into_results(self) -> (Vec<Option<T>>, ProcessesSample) {
        (self.results, self.sample)
    }
}

/// Reads a file `part.json`.
pub(crate) fn read_file(path: &Path) -> Result<PartFile, Error> {
    let error = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(error)?;
    serde_json::from_str(&text)
        .map_err(|reason| PartError::Description { path: path.to_owned(), reason }.into())
}
