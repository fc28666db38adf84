//! What a study is, and the one way in which all of them run.

mod crew;
mod run;

pub use crew::Crew;
pub use run::run;

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;

use clap::{Args, FromArgMatches};
use group::{Error, GroupOptions};
use report::results::{Document, ResultOptions};
use runtime::Mode;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::batch::{Done, Job, ProcessesSample, Repetition};
use crate::parts::{PartOptions, Records, Shard};

/// The options that all studies have, where an argument struct keeps them.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Parts; none where the study cannot be split.
    pub parts: Option<&'a PartOptions>,
    /// Runs at once; none: one per core, or one in realtime.
    pub jobs: Option<NonZeroUsize>,
    /// How processes are started.
    pub group: &'a GroupOptions,
    /// Where the results go.
    pub results: &'a ResultOptions,
}

/// What one run gave.
#[derive(Debug)]
pub struct Gave<R, S> {
    /// What is kept of it, in the journal too.
    pub record: R,
    /// What is kept in memory alone, such as a picture.
    pub seen: S,
    /// What came of repeating it in a process group; none: it was not repeated.
    pub repetition: Option<Repetition>,
}

/// When a result can be made of some of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Never: a part is only kept.
    All,
    /// Of a part, but not of runs that were interrupted.
    Part,
    /// Of any number of runs, also when the rest was interrupted.
    Any,
}

/// All that was done.
pub struct Found<S: Study> {
    /// What the runs gave, in the order of their numbers.
    pub records: Records<S::Record>,
    /// What was seen of the runs that this command did.
    pub seen: BTreeMap<usize, S::Seen>,
    /// Runs that were repeated in process groups.
    pub sample: ProcessesSample,
    /// The part that was done; none: the whole study.
    pub shard: Option<Shard>,
    /// Every run of the study, or of this part, is there.
    pub is_whole: bool,
}

/// A study: numbered runs, a record of each, and a judgement over all records.
///
/// Runs are done in the order of their numbers, several at a time, each in one thread. So a run may wait for one
/// with a smaller number. The judgement sees records alone, so that a study that was interrupted or split comes to
/// the same one.
pub trait Study: Sized + Sync {
    /// The command's arguments.
    type Arguments: Args + FromArgMatches;
    /// What is kept of a run: a line of the journal.
    type Record: Serialize + DeserializeOwned + Send;
    /// What is kept of a run in memory, for pictures; parts that are joined have none.
    type Seen: Send;

    /// Name of the command.
    const NAME: &'static str;
    /// When a result can be made of some of the runs.
    const NEEDS: Needs = Needs::Part;
    /// There may be too many records for memory: a journal is kept in any case.
    const KEEPS_JOURNAL: bool = false;
    /// A run that gave other bytes in a process group is a finding of the study. Otherwise it ends the study.
    const JUDGES_SAMPLE: bool = false;

    /// Where the arguments keep the common options.
    fn options(arguments: &Self::Arguments) -> Options<'_>;

    /// Reads and checks all that the arguments name. Nothing is written before.
    ///
    /// # Errors
    /// What is wrong with the arguments.
    fn plan(arguments: &Self::Arguments) -> Result<Self, Error>;

    /// Plans the study of the part in `directory`, by the arguments that it began with.
    ///
    /// # Errors
    /// As [`Study::plan`].
    fn reopen(arguments: &Self::Arguments, directory: &Path) -> Result<Self, Error> {
        let _ = directory;
        Self::plan(arguments)
    }

    /// Name and contents of a file that each part keeps, for [`Study::reopen`]: a part then needs no other file.
    fn inputs(&self) -> Option<(&'static str, String)> {
        None
    }

    /// Number of runs.
    fn runs(&self) -> usize;

    /// The clock of the runs.
    fn mode(&self) -> Mode {
        Mode::Lockstep
    }

    /// Chooses the runs that are repeated in process groups.
    fn seed(&self) -> u64 {
        1
    }

    /// Words beside the progress bar, and the name of a directory that the command names itself.
    fn label(&self) -> String {
        Self::NAME.to_owned()
    }

    /// A run by its number. It is made when its turn comes, in the thread that does it.
    ///
    /// # Errors
    /// What is wrong with its scenario.
    ///
    /// # Panics
    /// In a study that has a [`Study::drive`] of its own, unless it makes jobs too.
    fn job(&self, run: usize) -> Result<Job, Error> {
        unreachable!("run {run} of {} is not one job", Self::NAME)
    }

    /// What the files say that the words of the command name. Parts of other texts are not joined.
    ///
    /// # Errors
    /// As [`Study::job`].
    fn subject(&self) -> Result<String, Error> {
        Ok(self.job(0)?.scenario.to_toml())
    }

    /// What is kept of a run that ended, or that could not be brought up.
    ///
    /// # Errors
    /// What ends the study.
    ///
    /// # Panics
    /// In a study that has a [`Study::drive`] of its own.
    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Self::Record, Self::Seen), Error> {
        let _ = (job, result.is_ok());
        unreachable!("run {run} of {} is not one job", Self::NAME)
    }

    /// Does a run. A study whose run is not one drive has its own, and its own [`Study::subject`].
    ///
    /// # Errors
    /// What ends the study.
    fn drive(&self, run: usize, crew: &Crew<'_>) -> Result<Gave<Self::Record, Self::Seen>, Error> {
        crew.drive_and_record(self, run, &self.job(run)?)
    }

    /// True if no other run may go on beside this one. Such runs come last.
    ///
    /// # Errors
    /// As [`Study::job`].
    fn is_alone(&self, run: usize) -> Result<bool, Error> {
        let _ = run;
        Ok(false)
    }

    /// A line for standard error when a run has ended.
    fn notice(&self, record: &Self::Record) -> Option<String> {
        let _ = record;
        None
    }

    /// Words on a run, for the message that it gave other bytes in a process group.
    fn describe(&self, run: usize) -> String {
        let _ = run;
        String::new()
    }

    /// Judges the records.
    ///
    /// # Errors
    /// If a journal cannot be read.
    fn judge(&self, found: Found<Self>) -> Result<Document, Error>;
}
