//! The trait of all studies.

mod command;
mod crew;
mod entry;
mod run;
mod verify;

pub use command::{Command, MergeArguments, ResumeArguments, RunOptions};
pub use crew::Crew;
pub use entry::{Entry, merge, resume};
pub use run::run;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use report::results::{Column, Document};
use runtime::Mode;
use serde::Serialize;
use serde::de::DeserializeOwned;
use supervise::Error;

use crate::batch::{Done, Job};
use crate::parts::{Records, Shard};

/// Result of a run: its record, which goes into the journal, and data for pictures, which stays in memory alone.
pub type Recorded<S> = Result<(<S as Study>::Record, <S as Study>::Seen), Error>;

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
    /// The part that was done; `None` is the whole study.
    pub shard: Option<Shard>,
    /// Every run of the study, or of this part, is there.
    pub is_whole: bool,
    pub directory: PathBuf,
}

/// A study: numbered runs, a record of each, and a judgement over all records.
///
/// Runs are done in the order of their numbers, several at a time, each in one thread. So a run may wait for one
/// with a smaller number. The judgement sees records alone, so that it is the same
/// for a study that was interrupted or split.
pub trait Study: Sized + Sync {
    /// What the command asks. A part keeps it in `part.json`.
    type Arguments: Args + Serialize + DeserializeOwned;
    /// The record of a run: a line of the journal.
    type Record: Serialize + DeserializeOwned + Send + 'static;
    /// Data of a run for pictures, in memory alone. Merged parts do not have such data.
    type Seen: Send;

    /// Name of the study in `part.json`; no other study has it.
    const NAME: &'static str;
    /// Condition for a result of some of the runs.
    const NEEDS: Needs = Needs::Part;
    /// The study's own columns of `runs.csv`. A drive has those of its run's record.
    const OWN_COLUMNS: &'static [Column<Self::Record>] = &[];

    /// Reads and checks all that the arguments name. Nothing is written before.
    fn plan(arguments: &Self::Arguments, options: &RunOptions) -> Result<Self, Error>;

    fn runs(&self) -> usize;

    /// The clock of the runs.
    fn mode(&self) -> Mode {
        Mode::Lockstep
    }

    /// Words beside the progress bar, and the name of a directory that the command names itself.
    fn label(&self) -> String {
        Self::NAME.to_owned()
    }

    /// A run by its number. It is made when its turn comes, in the thread that does it.
    ///
    /// # Panics
    /// This holds in a study that has a [`Study::drive`] of its own, unless it makes jobs too.
    fn job(&self, run: usize) -> Result<Job, Error> {
        unreachable!("run {run} of {} is not one job", Self::NAME)
    }

    /// Content of the files that the arguments name. Parts of other contents are not joined.
    fn subject(&self) -> Result<String, Error> {
        Ok(self.job(0)?.scenario.to_toml())
    }

    /// Makes the record of a run that ended, or that could not be started.
    ///
    /// # Panics
    /// In a study that has a [`Study::drive`] of its own.
    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        let _ = (job, result.is_ok());
        unreachable!("run {run} of {} is not one job", Self::NAME)
    }

    /// Does a run. A study whose run is not one drive has its own, and its own [`Study::subject`].
    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        crew.drive_and_record(self, run, &self.job(run)?)
    }

    /// True if no other run may go on beside this one. Such runs come last.
    fn is_alone(&self, run: usize) -> Result<bool, Error> {
        let _ = run;
        Ok(false)
    }

    /// Takes a record that a journal kept, before the first run of this command begins. A study whose runs depend on
    /// earlier ones needs it.
    fn recall(&self, run: usize, record: &Self::Record) {
        let _ = (run, record);
    }

    /// Keys that the study varies, with their values in a run. They are columns of the table of drives, and of the
    /// trajectories that `--keep` keeps. All runs have the same keys. A run that has not begun may give any values
    /// of the same kinds: numbers, or words.
    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let _ = run;
        Vec::new()
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error>;
}
