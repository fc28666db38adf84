//! The means by which a study does its runs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard};

use group::{Error, GroupOptions};
use indicatif::ProgressBar;

use super::{RunResult, Study};
use crate::batch::{self, Done, Job};
use crate::drives::Drive;
use crate::keep::Keeper;
use crate::parts::{Begun, SoFar};
use scenario::Scenario;

/// Drives runs in threads or process groups, and repeats the runs of the sample.
pub struct Crew<'a> {
    group: &'a GroupOptions,
    repeated: &'a BTreeSet<usize>,
    going_on: &'a dyn Fn() -> bool,
    observed: &'a Observed<'a>,
}

/// Values taken of drives as they end, beside their records.
pub(super) struct Observed<'a> {
    /// Keeps trajectories.
    pub keeper: Option<&'a Keeper>,
    /// Counts the steps of all runs.
    bar: &'a ProgressBar,
    /// Keeps values of runs that have not ended.
    begun: Begun,
    /// Runs that are not settled.
    unsettled: Mutex<BTreeMap<usize, Unsettled>>,
}

/// Results so far of a run that is not settled.
#[derive(Default)]
struct Unsettled {
    /// Figures of its drives.
    drives: Vec<Drive>,
    /// Number of these figures that [`Begun`] has.
    kept: usize,
    /// Steps that it has reported.
    steps: u64,
}

impl<'a> Observed<'a> {
    /// `so_far` is what interrupted runs had computed.
    pub fn new(
        keeper: Option<&'a Keeper>,
        bar: &'a ProgressBar,
        (begun, so_far): (Begun, BTreeMap<usize, SoFar>),
    ) -> Self {
        let unsettled = so_far.into_iter().map(|(run, SoFar { values, drives })| {
            let (kept, steps) = (drives.len(), values.len() as u64);
            bar.inc(steps);
            (run, Unsettled { drives, kept, steps })
        });
        Self { keeper, bar, begun, unsettled: Mutex::new(unsettled.collect()) }
    }

    fn unsettled(&self) -> MutexGuard<'_, BTreeMap<usize, Unsettled>> {
        self.unsettled.lock().expect("no worker panics here")
    }

    /// A run of this number of steps ended: those that it did not report are over too. Returns the figures of its
    /// drives.
    pub fn end(&self, run: usize, steps: u64) -> Vec<Drive> {
        let one = self.unsettled().remove(&run).unwrap_or_default();
        self.bar.inc(steps.saturating_sub(one.steps));
        one.drives
    }
}

impl<'a> Crew<'a> {
    pub(super) fn new(
        group: &'a GroupOptions,
        repeated: &'a BTreeSet<usize>,
        going_on: &'a dyn Fn() -> bool,
        observed: &'a Observed<'a>,
    ) -> Self {
        Self { group, repeated, going_on, observed }
    }

    /// Start of processes.
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

    /// Takes a drive of run `run` into the table of all drives, and keeps its trajectory if that is asked for. `keys`
    /// are those of [`Study::keys`], with their values in this drive.
    pub fn observe(&self, run: usize, keys: &[(String, String)], scenario: &Scenario, done: &Done) {
        if let Some(keeper) = self.observed.keeper {
            keeper.offer(run, scenario, keys, &done.summary, &done.drive);
        }
        let drive = Drive::of(scenario, keys, &done.summary);
        self.observed.unsettled().entry(run).or_default().drives.push(drive);
    }

    /// Reports a step of run `run`, which goes on: the progress bar moves.
    pub fn step(&self, run: usize) {
        self.observed.unsettled().entry(run).or_default().steps += 1;
        self.observed.bar.inc(1);
    }

    /// Keeps further values of run `run`, which goes on, and the figures of its drives: an interrupted study gives the
    /// values back by [`Study::recall_begun`]. Without a journal nothing is kept. Each value counts as a step.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn keep(&self, run: usize, values: &[f64]) -> Result<(), Error> {
        let mut unsettled = self.observed.unsettled();
        let one = unsettled.entry(run).or_default();
        self.observed.begun.keep(run, values, &one.drives[one.kept..])?;
        one.kept = one.drives.len();
        Ok(())
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
    ) -> Result<RunResult<S::Record, S::Seen>, Error> {
        let result = match self.drive(run, job) {
            result @ (Ok(_) | Err(Error::NotReady { .. } | Error::Runtime(_))) => result,
            Err(error) => return Err(error),
        };
        if let Ok(done) = &result {
            self.observe(run, &study.keys(run), &job.scenario, done);
        }
        let repetition = result.as_ref().ok().and_then(|done| done.repetition.clone());
        let (record, seen) = study.record(run, job, result)?;
        Ok(RunResult { record, seen, repetition })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_move_the_bar_before_their_run_ends() {
        let bar = ProgressBar::hidden();
        let so_far = SoFar { values: vec![0.5], ..SoFar::default() };
        let begun = (Begun::default(), BTreeMap::from([(9, so_far)]));
        let observed = Observed::new(None, &bar, begun);
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 1.0, processes: false };
        let sample = BTreeSet::new();
        let crew = Crew::new(&group, &sample, &|| true, &observed);
        crew.step(7);
        crew.step(7);
        assert_eq!(bar.position(), 3, "an earlier command did one");
        // A run that reports no steps, and one that skips two of five.
        observed.end(3, 1);
        crew.step(7);
        observed.end(7, 5);
        observed.end(9, 2);
        assert_eq!(bar.position(), 8);
    }
}
