//! Many runs, several at a time.
//!
//! Each worker is a thread that does one run after the other: in lockstep by itself, with all services
//! in its own thread; in realtime, or where processes are asked for, through a process group. A seeded
//! sample of what ran in one process is repeated in process groups, and must give the same bytes. An
//! interrupt reaches every run that goes on and keeps further ones from beginning; what finished before
//! is kept.

pub mod laws;
mod leftovers;
mod sample;
mod scratch;
mod usage;
mod workers;

pub use sample::{OtherBytes, ProcessesSample, Repetition, choose};
pub use scratch::Scratch;
pub use usage::Growth;
pub use workers::share;

use group::in_process::Ahead;
use group::{
    Drive, Ended, Error, Failure, GroupOptions, GroupOutcome, Keep, Moment, SignalsError, Status,
};
use indicatif::ProgressBar;
pub use leftovers::leftovers;
use report::summary::Summary;
use runtime::report::Outcome;
use runtime::{Carrier, Mode, Sealing};
use scenario::Scenario;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use usage::Sample;

/// A run to be done.
#[derive(Clone, Debug)]
pub struct Job {
    /// What happens in it.
    pub scenario: Scenario,
    /// Clock.
    pub mode: Mode,
    /// Time between two samples of what the run's processes have; none: no samples.
    pub sample_every: Option<Duration>,
    /// Record the run, to a file that is removed with it.
    pub record: bool,
}

/// A run that was done.
#[derive(Debug)]
pub struct Done {
    /// What it measured.
    pub summary: Summary,
    /// What was heard of the drive.
    pub drive: Drive,
    /// What it left behind: it should be nothing.
    pub leftovers: Vec<String>,
    /// What its processes had, from time to time.
    pub samples: Vec<Sample>,
    /// Of a run in one process that was repeated in a group: whether it gave the same bytes, or what
    /// is different.
    pub repetition: Option<Repetition>,
}

impl Job {
    /// A lockstep run.
    pub fn lockstep(scenario: Scenario) -> Self {
        Self { scenario, mode: Mode::Lockstep, sample_every: None, record: false }
    }

    /// What carries the run's messages.
    fn carrier(&self, group: &GroupOptions) -> Carrier {
        match self.sample_every {
            Some(_) => Carrier::SharedMemory,
            None => carrier(group, self.mode),
        }
    }
}

/// What carries the messages of a run, as far as its clock and the options say.
fn carrier(group: &GroupOptions, mode: Mode) -> Carrier {
    let needs_processes = group.processes || mode == Mode::Realtime || !group.programs.is_empty();
    if needs_processes { Carrier::SharedMemory } else { Carrier::Memory }
}

/// How many runs go on at once: so many as chosen, or as there are cores; in realtime one, since
/// runs that share cores would measure each other.
pub fn at_once(chosen: Option<NonZeroUsize>, mode: Mode) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    chosen.map_or_else(|| if mode == Mode::Realtime { 1 } else { cores() }, NonZeroUsize::get)
}

/// Does the jobs, `at_once` at a time, in their order. `each` gets every run's index and result as
/// it ends, in this thread; a run that could not be brought up is a result too. An error that `each`
/// returns ends the batch. Says which runs were repeated in process groups.
///
/// # Errors
/// [`Error::Interrupted`] when a signal asked for the end, what keeps every run from starting, what
/// `each` returned, or [`OtherBytes`] if a repeated run gave other bytes; in each case when all
/// runs are over.
pub fn run(
    jobs: &[Job],
    at_once: usize,
    group: &GroupOptions,
    bar: &ProgressBar,
    each: &mut dyn FnMut(usize, Result<Done, Error>) -> Result<(), Error>,
) -> Result<ProcessesSample, Error> {
    let in_process = |index: &usize| jobs[*index].carrier(group) == Carrier::Memory;
    let candidates: Vec<usize> = (0..jobs.len()).filter(in_process).collect();
    let seed = jobs.first().map_or(0, |job| job.scenario.seed.value());
    let chosen = sample::choose(seed, candidates.len());
    let repeated = chosen.into_iter().map(|index| candidates[index]).collect();
    let sample = run_repeating(&repeated, jobs, at_once, group, bar, each)?;
    sample.print(jobs.len(), bar);
    let sample = sample.agreed(|index| {
        let scenario = &jobs[index].scenario;
        let (name, law) = (scenario.name.as_str(), scenario.controller.name.as_str());
        format!(" ({name} with {law}, seed {})", scenario.seed.value())
    });
    Ok(sample?)
}

/// The same with the choice of the runs to be repeated, and without a word on them; a repeated run
/// that gave other bytes is in its result alone.
///
/// # Errors
/// As [`run`], but for [`OtherBytes`].
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

/// Runs that are made when their turn comes: the scenarios of all of them at once would not fit in
/// memory.
pub struct Source<'a> {
    /// How many.
    pub runs: usize,
    /// Makes one by its index, in the thread that will do it.
    pub make: &'a (dyn Fn(usize) -> Result<Job, Error> + Sync),
}

/// What is told of a run that ended: its index, the run, what came of it.
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
            let result = drive_and_repeat(&job, group, repeated.contains(&index), going_on);
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
    share(source.runs, at_once, bar, &work, &mut take)?;
    Ok(sample)
}

/// What a run needs of the machine cannot be had.
#[derive(Debug, thiserror::Error)]
#[error("cannot {what}: {cause}")]
pub struct PrepareError {
    what: &'static str,
    cause: std::io::Error,
}

impl PrepareError {
    /// Makes an error out of the system's.
    pub fn of(what: &'static str) -> impl Fn(std::io::Error) -> Self + Copy {
        move |cause| Self { what, cause }
    }
}

impl Failure for PrepareError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// A run did not reach its end.
#[derive(Debug, thiserror::Error)]
#[error("{scenario} with {controller}: {}", why.as_deref().unwrap_or("aborted"))]
pub struct Aborted {
    scenario: String,
    controller: String,
    /// As its summary says.
    why: Option<String>,
}

impl Failure for Aborted {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// A run that did not reach its end has no figures.
///
/// # Errors
/// [`Aborted`].
pub fn whole(summary: &Summary) -> Result<(), Aborted> {
    match (&summary.outcome, &summary.aborted_because) {
        (Outcome::Aborted, why) => Err(Aborted {
            scenario: summary.scenario.clone(),
            controller: summary.controller.clone(),
            why: why.clone(),
        }),
        _ => Ok(()),
    }
}

/// Does one lockstep run, and repeats it in a process group if `repeat` says so and it was none.
///
/// # Errors
/// As [`run`].
pub fn lockstep(
    scenario: &Scenario,
    group: &GroupOptions,
    repeat: bool,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let job = Job::lockstep(scenario.clone());
    drive_and_repeat(&job, group, repeat, going_on)
}

/// Repeats a lockstep run that was done in one process in a process group: the same bytes and figures,
/// or what is different.
///
/// # Errors
/// As [`run`].
pub fn repeat(
    scenario: &Scenario,
    summary: &Summary,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Repetition, Error> {
    repetition(&Job::lockstep(scenario.clone()), summary, group, going_on)
}

/// True if a lockstep run's services share the thread that does it.
#[must_use]
pub fn in_one_thread(group: &GroupOptions) -> bool {
    carrier(group, Mode::Lockstep) == Carrier::Memory
}

/// Refuses, ahead of all runs, a scenario that its run would refuse.
///
/// # Errors
/// What is in the way.
pub fn check(scenario: &Scenario, mode: Mode, group: &GroupOptions) -> Result<(), Error> {
    group.programs()?;
    match carrier(group, mode) {
        Carrier::Memory => Ok(group::check_in_process(scenario)?),
        Carrier::SharedMemory => Ok(()),
    }
}

/// Does one lockstep run in this thread, behind a vehicle whose table of speeds grows meanwhile; `watch`
/// sees it go.
///
/// # Errors
/// As [`run`].
pub fn lockstep_behind(
    scenario: &Scenario,
    sealing: Sealing,
    ahead: Ahead,
    going_on: &dyn Fn() -> bool,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<Done, Error> {
    let begun = Instant::now();
    let outcome = group::in_process::run_behind(scenario, sealing, ahead, &|| !going_on(), watch)?;
    done(scenario, Mode::Lockstep, outcome, begun, Vec::new())
}

pub(crate) fn drive_and_repeat(
    job: &Job,
    group: &GroupOptions,
    repeat: bool,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let carrier = job.carrier(group);
    let repeat = repeat && carrier == Carrier::Memory;
    // Digests are there to be compared.
    let sealing = if repeat { Sealing::Sealed } else { Sealing::Unsealed };
    let mut done = drive(job, carrier, sealing, group, going_on)?;
    if repeat {
        done.repetition = Some(repetition(job, &done.summary, group, going_on)?);
    }
    Ok(done)
}

/// Repeats a run in a process group: the same bytes, or what is different.
fn repetition(
    job: &Job,
    in_process: &Summary,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Repetition, Error> {
    match drive(job, Carrier::SharedMemory, Sealing::Sealed, group, going_on) {
        Ok(again) => Ok({
            sample::difference(in_process, &again.summary)
                .map_or(Repetition::Same, Repetition::Different)
        }),
        Err(error @ (Error::NotReady { .. } | Error::Runtime(_))) => {
            Ok(Repetition::Different(error.to_string()))
        }
        Err(error) => Err(error),
    }
}

fn drive(
    job: &Job,
    carrier: Carrier,
    sealing: Sealing,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let begun = Instant::now();
    let mut samples: Vec<Sample> = Vec::new();
    let mut next = Duration::ZERO;
    let outcome = match carrier {
        Carrier::Memory => match sealing {
            Sealing::Sealed => {
                group::in_process::run_watched(&job.scenario, &|| !going_on(), &mut |_| {})?
            }
            Sealing::Unsealed => group::in_process::run_unsealed(&job.scenario, &|| !going_on())?,
        },
        Carrier::SharedMemory => {
            let directory = job.record.then(Scratch::new).transpose();
            let directory = directory.map_err(PrepareError::of("make a directory"))?;
            let keep = directory.as_ref().map(|directory| Keep {
                recording: Some(directory.path().join("topics.mcap")),
                ..Keep::default()
            });
            group::drive(&job.scenario, job.mode, group, keep, &mut |moment| {
                let time = Duration::from_nanos(moment.time_ns.max(0).unsigned_abs());
                if let Some(every) = job.sample_every.filter(|_| time >= next) {
                    samples.push(Sample::take());
                    next = time + every;
                }
            })?
        }
    };
    done(&job.scenario, job.mode, outcome, begun, samples)
}

/// What came of a run that began at `begun` and is over.
fn done(
    scenario: &Scenario,
    mode: Mode,
    outcome: GroupOutcome,
    begun: Instant,
    samples: Vec<Sample>,
) -> Result<Done, Error> {
    if outcome.ended == Ended::Interrupted {
        return Err(Error::Interrupted);
    }
    let summary = Summary::new(scenario, mode, &outcome, begun.elapsed());
    let leftovers = match outcome.carrier {
        // A thread leaves nothing behind.
        Carrier::Memory => Vec::new(),
        Carrier::SharedMemory => leftovers(&outcome.root),
    };
    Ok(Done { summary, drive: outcome.drive, leftovers, samples, repetition: None })
}

/// Notices the signals that ask for an end also between two groups, when no group listens.
pub struct Interrupt {
    came: Arc<AtomicBool>,
    registered: Vec<signal_hook::SigId>,
}

impl Interrupt {
    /// Begins to notice.
    ///
    /// # Errors
    /// If the signals cannot be handled.
    pub fn watch() -> Result<Self, SignalsError> {
        let came = Arc::new(AtomicBool::new(false));
        let registered = group::end_signals()
            .into_iter()
            .map(|signal| signal_hook::flag::register(signal, Arc::clone(&came)))
            .collect::<Result<_, _>>()?;
        Ok(Self { came, registered })
    }

    /// True once such a signal came.
    pub fn came(&self) -> bool {
        self.came.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        for &id in &self.registered {
            signal_hook::low_level::unregister(id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn realtime_runs_have_the_machine_to_themselves_unless_asked() {
        assert_eq!(at_once(None, Mode::Realtime), 1);
        assert_eq!(at_once(NonZeroUsize::new(3), Mode::Realtime), 3);
        assert!(at_once(None, Mode::Lockstep) >= 1);
    }
}
