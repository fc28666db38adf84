//! The means by which a study does its runs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

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
    /// Figures of the drives of runs that are not settled.
    drives: Mutex<BTreeMap<usize, Vec<Drive>>>,
    /// Number of these figures that `begun` has.
    kept: Mutex<BTreeMap<usize, usize>>,
    /// Steps that these runs have reported.
    steps: Mutex<BTreeMap<usize, u64>>,
}

impl<'a> Observed<'a> {
    /// `so_far` is what interrupted runs had computed.
    pub fn new(
        keeper: Option<&'a Keeper>,
        bar: &'a ProgressBar,
        (begun, so_far): (Begun, BTreeMap<usize, SoFar>),
    ) -> Self {
        let kept = so_far.iter().map(|(run, one)| (*run, one.drives.len())).collect();
        let steps: BTreeMap<usize, u64> =
            so_far.iter().map(|(run, one)| (*run, one.values.len() as u64)).collect();
        bar.inc(steps.values().sum());
        let drives = so_far.into_iter().map(|(run, one)| (run, one.drives)).collect();
        let (drives, kept, steps) = (Mutex::new(drives), Mutex::new(kept), Mutex::new(steps));
        Self { keeper, bar, begun, drives, kept, steps }
    }

    /// A run of this number of steps ended: those that it did not report are over too.
    pub fn end(&self, run: usize, steps: u64) {
        let reported = self.steps.lock().expect("no worker panics here").remove(&run);
        self.bar.inc(steps.saturating_sub(reported.unwrap_or(0)));
    }

    /// The figures of the drives of a run that ended.
    pub fn take(&self, run: usize) -> Vec<Drive> {
        let mut drives = self.drives.lock().expect("no worker panics here");
        drives.remove(&run).unwrap_or_default()
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
        let mut drives = self.observed.drives.lock().expect("no worker panics here");
        drives.entry(run).or_default().push(drive);
    }

    /// Reports a step of run `run`, which goes on: the progress bar moves.
    pub fn step(&self, run: usize) {
        let mut steps = self.observed.steps.lock().expect("no worker panics here");
        *steps.entry(run).or_default() += 1;
        self.observed.bar.inc(1);
    }

    /// Keeps further values of run `run`, which goes on, and the figures of its drives: an interrupted study gives the
    /// values back by [`Study::recall_begun`]. Without a journal nothing is kept. Each value counts as a step.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn keep(&self, run: usize, values: &[f64]) -> Result<(), Error> {
        let drives = self.observed.drives.lock().expect("no worker panics here");
        let drives: &[Drive] = drives.get(&run).map_or(&[], Vec::as_slice);
        let mut kept = self.observed.kept.lock().expect("no worker panics here");
        let kept = kept.entry(run).or_default();
        self.observed.begun.keep(run, values, &drives[*kept..])?;
        *kept = drives.len();
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
