//! The means by which a study does its runs.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard};

use indicatif::ProgressBar;
use scenario::Scenario;
use supervise::{Error, GroupOptions};

use super::verify::{self, Verify};
use super::{Recorded, Study};
use crate::batch::{self, Done, Job};
use crate::drives::Drive;
use crate::keep::Keeper;
use crate::parts::{Begun, SoFar};

/// Drives runs in threads or process groups.
pub struct Crew<'a> {
    group: &'a GroupOptions,
    going_on: &'a dyn Fn() -> bool,
    observed: &'a Observed<'a>,
}

/// Values taken of drives as they end, beside their records.
pub(crate) struct Observed<'a> {
    keeper: Option<&'a Keeper>,
    verify: Verify,
    bar: &'a ProgressBar,
    /// Keeps values of runs that have not ended.
    begun: Begun,
    unsettled: Mutex<BTreeMap<usize, Unsettled>>,
}

/// Results so far of a run that has not ended.
#[derive(Default)]
struct Unsettled {
    /// Values that an interrupted command had kept.
    recalled: Vec<f64>,
    drives: Vec<Drive>,
    /// Number of these drives that [`Begun`] has.
    kept: usize,
    /// Steps that it does, and those that it has done.
    steps: [u64; 2],
}

impl<'a> Observed<'a> {
    /// `so_far` is what interrupted runs had computed.
    pub fn new(
        keeper: Option<&'a Keeper>,
        verify: Verify,
        bar: &'a ProgressBar,
        (begun, so_far): (Begun, BTreeMap<usize, SoFar>),
    ) -> Self {
        let unsettled = so_far.into_iter().map(|(run, SoFar { values, drives })| {
            let kept = drives.len();
            (run, Unsettled { recalled: values, drives, kept, steps: [0; 2] })
        });
        Self { keeper, verify, bar, begun, unsettled: Mutex::new(unsettled.collect()) }
    }

    fn unsettled(&self) -> MutexGuard<'_, BTreeMap<usize, Unsettled>> {
        self.unsettled.lock().expect("no worker panics here")
    }

    /// A run ended: the steps that it did not report are over too. Returns the figures of its drives.
    pub fn end(&self, run: usize) -> Vec<Drive> {
        let one = self.unsettled().remove(&run).unwrap_or_default();
        let [steps, done] = one.steps;
        self.bar.inc(steps.max(1).saturating_sub(done));
        one.drives
    }

    /// Runs that were repeated in process groups.
    pub fn verified(&self) -> usize {
        self.verify.count()
    }
}

impl<'a> Crew<'a> {
    pub(crate) fn new(
        group: &'a GroupOptions,
        going_on: &'a dyn Fn() -> bool,
        observed: &'a Observed<'a>,
    ) -> Self {
        Self { group, going_on, observed }
    }

    /// Start of processes.
    pub fn group(&self) -> &GroupOptions {
        self.group
    }

    /// False once the study was interrupted or has failed.
    pub fn going_on(&self) -> &dyn Fn() -> bool {
        self.going_on
    }

    /// Writes a line on standard error, above the progress bar.
    pub fn note(&self, line: &str) {
        self.observed.bar.suspend(|| report::print::note(line));
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

    /// Run `run` is of this number of steps. It reports each by [`Crew::step`].
    pub fn steps(&self, run: usize, steps: usize) {
        self.observed.unsettled().entry(run).or_default().steps[0] = steps as u64;
        self.observed.bar.inc_length((steps as u64).saturating_sub(1));
    }

    /// Reports a step of run `run`, which goes on: the progress bar moves.
    pub fn step(&self, run: usize) {
        self.observed.unsettled().entry(run).or_default().steps[1] += 1;
        self.observed.bar.inc(1);
    }

    /// Keeps further values of run `run`, which goes on, and the figures of its drives. An interrupted study gives the
    /// values back by [`Crew::recalled`].
    pub fn keep(&self, run: usize, values: &[f64]) -> Result<(), Error> {
        let mut unsettled = self.observed.unsettled();
        let one = unsettled.entry(run).or_default();
        self.observed.begun.keep(run, values, &one.drives[one.kept..])?;
        one.kept = one.drives.len();
        Ok(())
    }

    /// Values that an interrupted command kept of run `run`, once.
    pub fn recalled(&self, run: usize) -> Vec<f64> {
        let mut unsettled = self.observed.unsettled();
        unsettled.get_mut(&run).map(|one| std::mem::take(&mut one.recalled)).unwrap_or_default()
    }

    /// Does a drive of run `run`. With `--verify-processes` it may be repeated in a process group.
    pub fn drive(&self, run: usize, job: &Job) -> Result<Done, Error> {
        if self.observed.verify.takes(run) && batch::is_in_memory(job, self.group) {
            return verify::twice(run, job, self.group, self.going_on);
        }
        batch::drive(job, self.group, self.going_on)
    }

    /// Drives, and lets the study record the run. A failure of this run alone is its result.
    pub fn drive_and_record<S: Study>(&self, study: &S, run: usize, job: &Job) -> Recorded<S> {
        let result = match self.drive(run, job) {
            result @ (Ok(_) | Err(Error::NotReady { .. } | Error::Runtime(_))) => result,
            Err(error) => return Err(error),
        };
        if let Ok(done) = &result {
            self.observe(run, &study.keys(run), &job.scenario, done);
        }
        study.record(run, job, result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_move_the_bar_before_their_run_ends() {
        let bar = ProgressBar::hidden();
        bar.set_length(3);
        let so_far = SoFar { values: vec![0.5], ..SoFar::default() };
        let begun = (Begun::default(), BTreeMap::from([(9, so_far)]));
        let observed = Observed::new(None, Verify::default(), &bar, begun);
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 1.0, processes: false };
        let crew = Crew::new(&group, &|| true, &observed);
        assert_eq!(
            (crew.recalled(9), crew.recalled(9), crew.recalled(3)),
            (vec![0.5], vec![], vec![])
        );
        crew.steps(7, 5);
        crew.step(7);
        crew.step(7);
        assert_eq!((bar.position(), bar.length()), (2, Some(7)));
        // A run that reports no steps, and one that skips two of five.
        observed.end(3);
        crew.step(7);
        observed.end(7);
        observed.end(9);
        assert_eq!(bar.position(), 7);
    }
}
