//! One run: driven, repeated, compared.

use super::errors::PrepareError;
use super::usage::Sample;
use super::{Done, Job, Repetition, Scratch, leftovers, sample};
use group::in_process::Ahead;
use group::{Ended, Error, GroupOptions, GroupOutcome, Keep, Moment};
use report::summary::Summary;
use runtime::{Carrier, Mode, Sealing};
use scenario::Scenario;
use std::time::{Duration, Instant};

/// Does one lockstep run. With `repeat`, a run in memory is repeated in a process group.
///
/// # Errors
/// Reasons why the run does not start, or [`Error::Interrupted`].
pub fn lockstep(
    scenario: &Scenario,
    group: &GroupOptions,
    repeat: bool,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let job = Job::lockstep(scenario.clone());
    drive_and_repeat(&job, group, repeat, going_on)
}

/// Does one realtime run, in a process group.
///
/// # Errors
/// Reasons why the run does not start, or [`Error::Interrupted`].
pub fn realtime(
    scenario: &Scenario,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let job = Job { mode: Mode::Realtime, ..Job::lockstep(scenario.clone()) };
    drive_and_repeat(&job, group, false, going_on)
}

/// Repeats a lockstep run that was done in memory in a process group, and compares bytes and figures.
///
/// # Errors
/// Reasons why the run does not start, or [`Error::Interrupted`].
pub fn repeat(
    scenario: &Scenario,
    summary: &Summary,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Repetition, Error> {
    repetition(&Job::lockstep(scenario.clone()), summary, group, going_on)
}

/// Does one lockstep run in this thread, behind a vehicle whose table of speeds grows meanwhile. `watch` is called at
/// each moment of it.
///
/// # Errors
/// Reasons why the run does not start, or [`Error::Interrupted`].
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

/// Repeats a run in a process group and compares.
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

/// The result of a run that began at `begun` and is over.
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
