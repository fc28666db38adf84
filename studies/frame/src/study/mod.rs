//! The trait of all studies, and the one way in which they run.

mod crew;
mod run;
mod schema;

pub use crew::Crew;
pub use run::run;
pub use schema::{ok, schema};

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{Args, FromArgMatches};
use group::{Error, GroupOptions};
use report::results::{Column, Document, ResultOptions};
use runtime::Mode;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::batch::{Done, Job, ProcessesSample, Repetition};
use crate::keep::{self, Keep, Key};
use crate::parts::{PartOptions, Records, Shard};

/// The options that all studies have, where an argument struct keeps them.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Parts; none where the study cannot be split.
    pub parts: Option<&'a PartOptions>,
    /// Runs at once; none: one per core, or one in realtime.
    pub jobs: Option<NonZeroUsize>,
    /// Start of processes.
    pub group: &'a GroupOptions,
    /// Directory and forms of the results.
    pub results: &'a ResultOptions,
}

/// Results of one run.
#[derive(Debug)]
pub struct RunResult<R, S> {
    /// Its record, which goes into the journal too.
    pub record: R,
    /// Data for pictures, which stays in memory alone.
    pub seen: S,
    /// Result of repeating it in a process group; none: it was not repeated.
    pub repetition: Option<Repetition>,
}

/// Condition for a result of some of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// All runs are needed: a part is only kept.
    All,
    /// A part gives a result, interrupted runs do not.
    Part,
    /// Any number of runs gives a result, also when the rest was interrupted.
    Any,
}

/// All that was done.
pub struct Found<S: Study> {
    /// The records, in the order of the runs' numbers.
    pub records: Records<S::Record>,
    /// Data for pictures, of the runs that this command did.
    pub seen: BTreeMap<usize, S::Seen>,
    /// Runs that were repeated in process groups.
    pub sample: ProcessesSample,
    /// The part that was done; none: the whole study.
    pub shard: Option<Shard>,
    /// Every run of the study, or of this part, is there.
    pub is_whole: bool,
    /// The directory of the results.
    pub directory: PathBuf,
}

/// A study: numbered runs, a record of each, and a judgement over all records.
///
/// Runs are done in the order of their numbers, several at a time, each in one thread. So a run may wait for one
/// with a smaller number. The judgement sees records alone, so that it is the same
/// for a study that was interrupted or split.
pub trait Study: Sized + Sync {
    /// The command's arguments.
    type Arguments: Args + FromArgMatches;
    /// The record of a run: a line of the journal.
    type Record: Serialize + DeserializeOwned + Send;
    /// Data of a run for pictures, in memory alone. Merged parts do not have such data.
    type Seen: Send;

    /// Name of the command.
    const NAME: &'static str;
    /// Condition for a result of some of the runs.
    const NEEDS: Needs = Needs::Part;
    /// There may be too many records for memory: a journal is kept in any case.
    const KEEPS_JOURNAL: bool = false;
    /// A run that gave other bytes in a process group is a finding of the study. Otherwise it ends the study.
    const JUDGES_SAMPLE: bool = false;

    /// Finds the common options in the arguments.
    fn options(arguments: &Self::Arguments) -> Options<'_>;

    /// The trajectories to keep. A study that cannot be split has an option of its own.
    fn keep(arguments: &Self::Arguments) -> Option<Keep> {
        Self::options(arguments).parts.and_then(|parts| parts.keep)
    }

    /// Reads and checks all that the arguments name. Nothing is written before.
    ///
    /// # Errors
    /// Mistakes in the arguments.
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

    /// The study's own columns of `runs.csv`. A drive has those of its run's record.
    fn own_columns(&self) -> Vec<Column<Self::Record>> {
        Vec::new()
    }

    /// Words beside the progress bar, and the name of a directory that the command names itself.
    fn label(&self) -> String {
        Self::NAME.to_owned()
    }

    /// A run by its number. It is made when its turn comes, in the thread that does it.
    ///
    /// # Errors
    /// Mistakes in its scenario.
    ///
    /// # Panics
    /// This holds in a study that has a [`Study::drive`] of its own, unless it makes jobs too.
    fn job(&self, run: usize) -> Result<Job, Error> {
        unreachable!("run {run} of {} is not one job", Self::NAME)
    }

    /// Content of the files that the command names. Parts of other contents are not joined.
    ///
    /// # Errors
    /// As [`Study::job`].
    fn subject(&self) -> Result<String, Error> {
        Ok(self.job(0)?.scenario.to_toml())
    }

    /// Makes the record of a run that ended, or that could not be started.
    ///
    /// # Errors
    /// Errors that end the study.
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
    /// Errors that end the study.
    fn drive(
        &self,
        run: usize,
        crew: &Crew<'_>,
    ) -> Result<RunResult<Self::Record, Self::Seen>, Error> {
        crew.drive_and_record(self, run, &self.job(run)?)
    }

    /// Steps of a run, as the progress bar counts them. A run of several reports each by [`Crew::step`].
    fn steps(&self, run: usize) -> usize {
        let _ = run;
        1
    }

    /// True if no other run may go on beside this one. Such runs come last.
    ///
    /// # Errors
    /// As [`Study::job`].
    fn is_alone(&self, run: usize) -> Result<bool, Error> {
        let _ = run;
        Ok(false)
    }

    /// Takes a record that a journal kept, before the first run of this command begins. A study whose runs depend on
    /// earlier ones needs it.
    fn recall(&self, run: usize, record: &Self::Record) {
        let _ = (run, record);
    }

    /// Takes the values that an interrupted run had kept ([`Crew::keep`]), before the first run of this command begins.
    fn recall_begun(&self, run: usize, values: &[f64]) {
        let _ = (run, values);
    }

    /// Keys that the study varies, with their values in a run. They are columns of the table of drives, and of the
    /// trajectories that `--keep` keeps. All runs have the same keys. It is asked for a run that is under way.
    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let _ = run;
        Vec::new()
    }

    /// The same keys without values, by those of `runs`, none of which need have begun. A study that chooses values by
    /// the results of earlier runs has its own.
    fn columns(&self, runs: &[usize]) -> Vec<Key> {
        keep::keys(runs.iter().map(|run| self.keys(*run)))
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
