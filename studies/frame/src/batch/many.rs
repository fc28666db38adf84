//! Many runs for a command that is not a [`Study`](crate::Study).

use super::{Done, Job, ProcessesSample};
use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use std::collections::BTreeSet;

/// Does the jobs, `at_once` at a time, in their order, and repeats the chosen ones in process groups. `each` receives
/// every run's index and result as it ends, in this thread. A run that could not be brought up is a result too.
///
/// # Errors
/// [`Error::Interrupted`] when a signal asked for the end, what keeps every run from starting, or an error of `each`.
pub fn run_repeating(
    repeated: &BTreeSet<usize>,
    jobs: &[Job],
    at_once: usize,
    group: &GroupOptions,
    bar: &ProgressBar,
    each: &mut dyn FnMut(usize, Result<Done, Error>) -> Result<(), Error>,
) -> Result<ProcessesSample, Error> {
    let source = Source { runs: jobs.len(), make: &|index| Ok(jobs[index].clone()) };
    let mut each = |index, _: &Job, result| each(index, result);
    run_made(repeated, &source, at_once, group, bar, &mut each)
}

/// Runs that are made when their turn comes. The scenarios of all of them do not fit in memory.
pub struct Source<'a> {
    /// Number of runs.
    pub runs: usize,
    /// Makes one by its index, in the thread that will do it.
    pub make: &'a (dyn Fn(usize) -> Result<Job, Error> + Sync),
}

/// Receives a run that ended: its index, the run, its result.
pub type Each<'a> = dyn FnMut(usize, &Job, Result<Done, Error>) -> Result<(), Error> + 'a;

/// The same of runs that are made when their turn comes.
///
/// # Errors
/// As [`run_repeating`], or what `make` returns.
pub fn run_made(
    repeated: &BTreeSet<usize>,
    source: &Source<'_>,
    at_once: usize,
    group: &GroupOptions,
    bar: &ProgressBar,
    each: &mut Each<'_>,
) -> Result<ProcessesSample, Error> {
    let work = |index, going_on: &dyn Fn() -> bool| match (source.make)(index) {
        Ok(job) => {
            let result = super::drive_and_repeat(&job, group, repeated.contains(&index), going_on);
            (Some(job), result)
        }
        Err(error) => (None, Err(error)),
    };
    let mut sample = ProcessesSample::default();
    let mut take = |index, (job, result): (Option<Job>, Result<Done, Error>)| {
        if let Ok(done) = &result {
            sample.count(index, done.repetition.as_ref());
        }
        match (job, result) {
            // A failure of this run alone is its result.
            (Some(job), result @ (Ok(_) | Err(Error::NotReady { .. } | Error::Runtime(_)))) => {
                each(index, &job, result)
            }
            (_, Err(error)) => Err(error),
            (None, Ok(_)) => unreachable!("only a run that was made has an end"),
        }
    };
    super::share(source.runs, at_once, bar, &work, &mut take)?;
    Ok(sample)
}
