//! `--verify-processes`: some runs in memory are repeated in process groups, and must give the same bytes.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use report::summary::Summary;
use runtime::{Carrier, Sealing};
use supervise::{Error, Failure, GroupOptions, Status};

use crate::batch::{self, Done, Job};

/// One run in this number is repeated.
const EVERY: usize = 200;
/// Least number of repeated runs, as far as there are enough.
const LEAST: usize = 3;

/// A run in one process and the same run in a process group gave different bytes.
#[derive(Debug, thiserror::Error)]
#[error("run {run} in a process group: {why}")]
pub struct OtherBytes {
    run: usize,
    why: String,
}

impl Failure for OtherBytes {
    fn status(&self) -> Status {
        Status::Different
    }
}

/// The runs to repeat. The default is none.
#[derive(Debug, Default)]
pub(crate) struct Verify {
    stride: Option<usize>,
    count: AtomicUsize,
}

impl Verify {
    /// Evenly spread runs of `runs` in all.
    pub fn some_of(runs: usize) -> Self {
        let wanted = runs.div_ceil(EVERY).max(LEAST);
        Self { stride: Some((runs / wanted).max(1)), count: AtomicUsize::new(0) }
    }

    /// True if a drive of this run is to be repeated.
    pub fn takes(&self, run: usize) -> bool {
        let takes = self.stride.is_some_and(|stride| run.is_multiple_of(stride));
        self.count.fetch_add(usize::from(takes), Ordering::Relaxed);
        takes
    }

    /// Drives that were repeated.
    pub fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }
}

/// Drives in memory and in a process group, and compares bytes and figures.
pub(crate) fn twice(
    run: usize,
    job: &Job,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let drive = |carrier| batch::drive_on(job, carrier, Sealing::Sealed, group, going_on);
    let done = drive(Carrier::Memory)?;
    match difference(&done.summary, &drive(Carrier::SharedMemory)?.summary) {
        None => Ok(done),
        Some(why) => Err(OtherBytes { run, why }.into()),
    }
}

/// The difference of two runs of the same scenario: the first topic, the outcome, or the figures of the drive.
fn difference(one: &Summary, other: &Summary) -> Option<String> {
    let topics: BTreeSet<&String> = one.messages.keys().chain(other.messages.keys()).collect();
    let digests = |summary: &Summary, topic: &String| {
        summary.messages.get(topic).map(|counts| counts.digests.clone()).unwrap_or_default()
    };
    if let Some(topic) =
        topics.into_iter().find(|topic| digests(one, topic) != digests(other, topic))
    {
        return Some(format!("other bytes on {topic}"));
    }
    let figures = |summary: &Summary| {
        let control = serde_json::to_string(&summary.control).expect("figures are plain data");
        format!("{:?}, {control}", summary.outcome)
    };
    let (one, other) = (figures(one), figures(other));
    (one != other).then(|| format!("{one} in one process, {other} in a group"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_in_two_hundred_and_at_least_three_are_repeated() {
        for (runs, wanted) in [(1, 1), (2, 2), (3, 3), (600, 3), (10_000, 50)] {
            let verify = Verify::some_of(runs);
            let taken = (0..runs).filter(|run| verify.takes(*run)).count();
            assert_eq!((taken, verify.count()), (wanted, wanted), "of {runs}");
        }
        assert!(!Verify::default().takes(0));
    }

    #[test]
    fn a_difference_is_named() {
        let scenario =
            supervise::open("following", &supervise::ScenarioOptions::default()).expect("built in");
        let outcome = supervise::in_process::run_watched(
            &scenario,
            runtime::Sealing::Unsealed,
            &|| true,
            &mut |_| {},
        )
        .expect("it ends at once");
        let summary = || {
            let wall = std::time::Duration::ZERO;
            Summary::new(&scenario, runtime::Mode::Lockstep, &outcome, wall)
        };
        let (one, mut other) = (summary(), summary());
        assert_eq!(difference(&one, &other), None);
        other.control.figures.min_gap_m = Some(2.5);
        let said = difference(&one, &other).expect("another gap");
        assert!(said.contains("\"min_gap_m\":2.5"), "{said}");
    }
}
