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
mod records;
mod shard;
mod words;

pub use merge::{Incomplete, MergeError, Merged, incomplete, name_incomplete, refuse_into_part};
pub use records::Records;
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
        Self::of_command(runs, &first.to_toml())
    }

    /// The same with all that the words name, as text.
    pub(crate) fn of_command(runs: usize, subject: &str) -> Self {
        Self::of(words::of_study(std::env::args_os().skip(1)), runs, subject)
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

/// A part under way: its journal and what is left to do.
pub struct Part<T> {
    shard: Option<Shard>,
    study: Study,
    journal: Option<Journal>,
    records: Records<T>,
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
        let name = study.words.first().cloned().unwrap_or_default();
        Self::open_as(&name, options, output, study, false)
    }

    /// The same with a name for the directory; with a journal in any case where there are too many records for
    /// memory.
    ///
    /// # Errors
    /// As [`Part::open`].
    pub fn open_as(
        name: &str,
        options: &PartOptions,
        output: &OutputOptions,
        study: Study,
        keeps_journal: bool,
    ) -> Result<(Self, OutputDirectory), Error> {
        let shard = options.shard.map(ShardChoice::resolve).transpose()?;
        let directory = match &options.resume {
            Some(path) => OutputDirectory::resume(path, FILE)?,
            None => OutputDirectory::create(output, name)?,
        };
        let records = Records::new(study.runs);
        let sample = ProcessesSample::default();
        let mut part = Self { shard, journal: None, records, sample, study };
        if shard.is_some() || options.resume.is_some() || keeps_journal {
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
        let Self { records, sample, shard, .. } = self;
        records.begin(&directory.path().join(journal::FILE));
        let mut each = |place, line| Ok(take::<T>(records, sample, *shard, place, line)?);
        self.journal = Some(Journal::open(directory.path(), &mut each)?);
        Ok(())
    }

    /// The runs of this part that are left to do.
    pub fn left(&self) -> Vec<usize> {
        self.mine().filter(|run| !self.records.has(*run)).collect()
    }

    /// The runs of this part.
    fn mine(&self) -> impl Iterator<Item = usize> {
        (0..self.study.runs).filter(|run| holds(self.shard, *run))
    }

    /// Which part it is; none: the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// Runs of this part.
    pub fn runs(&self) -> usize {
        self.mine().count()
    }

    /// Those of `left` that are chosen to be repeated in process groups, by their places in it.
    pub fn repeated(&self, left: &[usize], seed: u64) -> BTreeSet<usize> {
        let chosen = crate::batch::choose(seed, self.study.runs);
        (0..left.len()).filter(|place| chosen.contains(&left[*place])).collect()
    }

    /// The runs of the whole study that are repeated in process groups.
    pub(crate) fn sampled(&self, seed: u64) -> BTreeSet<usize> {
        crate::batch::choose(seed, self.study.runs)
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
        self.sample.count(run, repetition);
        match &mut self.journal {
            Some(journal) => Ok(self.records.add(run, journal.add(&line)?, true)?),
            None => {
                self.records.keep(run, journal::as_read_back(&line).result);
                Ok(())
            }
        }
    }

    /// Reports the runs that were done of this part, `count` of them: those that were repeated in
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
    pub(crate) fn print_how_to_continue(&self, directory: &OutputDirectory) {
        if self.journal.is_some() {
            let (done, all) = (self.records.len(), self.runs());
            let command = runtime::command_line(&self.study.words);
            let shard = self
                .shard
                .map_or_else(String::new, |shard| format!(" --shard {}", String::from(shard)));
            let path = directory.path().display();
            eprintln!(
                "{done} of {all} runs are kept; to continue: timegap {command}{shard} --resume {path}"
            );
        }
    }

    /// What the runs gave, and what came of the repeated ones.
    pub fn into_records(self) -> (Records<T>, ProcessesSample) {
        (self.records, self.sample)
    }

    /// What the runs gave, by their numbers, and what came of the repeated ones.
    ///
    /// # Panics
    /// If the journal can no longer be read.
    pub fn into_results(self) -> (Vec<Option<T>>, ProcessesSample) {
        let (runs, sample) = (self.study.runs, self.sample);
        (by_number(runs, self.records).expect("the journal is there"), sample)
    }
}

/// Records in a list of all runs.
pub(crate) fn by_number<T: DeserializeOwned>(
    runs: usize,
    records: Records<T>,
) -> Result<Vec<Option<T>>, Error> {
    let mut results: Vec<Option<T>> = std::iter::repeat_with(|| None).take(runs).collect();
    for (run, record) in records.all()? {
        results[run] = Some(record);
    }
    Ok(results)
}

/// Whether a run belongs to a part: the only place that decides it.
fn holds(shard: Option<Shard>, run: usize) -> bool {
    shard.is_none_or(|shard| shard.holds(run))
}

/// Takes a line of the journal of a part.
fn take<T>(
    records: &mut Records<T>,
    sample: &mut ProcessesSample,
    shard: Option<Shard>,
    place: journal::Place,
    line: Line<T>,
) -> Result<(), JournalError> {
    records.add(line.run, place, holds(shard, line.run))?;
    let repetition = line.same_in_processes.map(Repetition::of_same);
    sample.count(line.run, repetition.as_ref());
    Ok(())
}

/// The study that `--resume` continues, where the command line names none.
pub(crate) fn begun(options: &PartOptions) -> Option<Result<Study, Error>> {
    let path = options.resume.as_ref()?.join(FILE);
    let is_named = words::of_study(std::env::args_os().skip(1)).len() > 1;
    (!is_named && path.exists()).then(|| Ok(read_file(&path)?.study))
}

/// Reads a file `part.json`.
pub(crate) fn read_file(path: &Path) -> Result<PartFile, Error> {
    let error = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(error)?;
    serde_json::from_str(&text)
        .map_err(|reason| PartError::Description { path: path.to_owned(), reason }.into())
}
