//! The means by which a study does its runs.

use std::collections::BTreeSet;

use group::{Error, GroupOptions};

use super::{Gave, Study};
use crate::batch::{self, Done, Job};
use crate::keep::Keeper;

/// Drives runs in threads or process groups, and repeats the runs of the sample.
pub struct Crew<'a> {
    group: &'a GroupOptions,
    repeated: &'a BTreeSet<usize>,
    going_on: &'a dyn Fn() -> bool,
    keeper: Option<&'a Keeper>,
}

impl<'a> Crew<'a> {
    pub(super) fn new(
        group: &'a GroupOptions,
        repeated: &'a BTreeSet<usize>,
        going_on: &'a dyn Fn() -> bool,
        keeper: Option<&'a Keeper>,
    ) -> Self {
        Self { group, repeated, going_on, keeper }
    }

    /// How processes are started.
    #[must_use]
    pub fn group(&self) -> &GroupOptions {
        self.group
    }

    /// False once the study was interrupted or has failed.
    pub fn going_on(&self) -> &dyn Fn() -> bool {
        self.going_on
    }

    /// True if run `run` is in the sample that is repeated in process groups.
    #[must_use]
    pub fn repeats(&self, run: usize) -> bool {
        self.repeated.contains(&run)
    }

    /// Drives, and repeats what is in the sample.
    ///
    /// # Errors
    /// Reasons why the run does not start, or [`Error::Interrupted`].
    pub fn drive(&self, run: usize, job: &Job) -> Result<Done, Error> {
        batch::drive_and_repeat(job, self.group, self.repeats(run), self.going_on)
    }

    /// Drives, repeats, and lets the study record the run. A failure of this run alone is its result.
    ///
    /// # Errors
    /// As [`Crew::drive`], or that of [`Study::record`].
    pub fn drive_and_record<S: Study>(
        &self,
        study: &S,
        run: usize,
        job: &Job,
    ) -> Result<Gave<S::Record, S::Seen>, Error> {
        let result = match self.drive(run, job) {
            result @ (Ok(_) | Err(Error::NotReady { .. } | Error::Runtime(_))) => result,
            Err(error) => return Err(error),
        };
        if let (Ok(done), Some(keeper)) = (&result, self.keeper) {
            keeper.offer(run, &job.scenario, &study.keys(run), done);
        }
        let repetition = result.as_ref().ok().and_then(|done| done.repetition.clone());
        let (record, seen) = study.record(run, job, result)?;
        Ok(Gave { record, seen, repetition })
    }
}
