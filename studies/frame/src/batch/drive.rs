//! One run, driven, with a directory for files that are not kept.

use super::usage::Sample;
use super::{Done, Job, carrier, leftovers};
use report::summary::Summary;
use runtime::{Carrier, Sealing};
use scenario::Scenario;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use supervise::report::Outcome;
use supervise::{Ended, Error, GroupOptions, Keep, MachineError};

/// Refuses a run that did not reach its end: it has no figures.
pub fn whole(summary: &Summary) -> Result<(), MachineError> {
    if summary.outcome != Outcome::Aborted {
        return Ok(());
    }
    let why = summary.aborted_because.as_deref().unwrap_or("aborted");
    Err(MachineError(format!("{} with {}: {why}", summary.scenario, summary.controller)))
}

/// Does one lockstep run.
pub fn lockstep(
    scenario: &Scenario,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    drive(&Job::lockstep(scenario.clone()), group, going_on)
}

/// Does one run.
pub fn drive(job: &Job, group: &GroupOptions, going_on: &dyn Fn() -> bool) -> Result<Done, Error> {
    let carrier = match is_in_memory(job, group) {
        true => Carrier::Memory,
        false => Carrier::SharedMemory,
    };
    drive_on(job, carrier, Sealing::Unsealed, group, going_on)
}

/// True if the services of the run share the thread that does it.
pub(crate) fn is_in_memory(job: &Job, group: &GroupOptions) -> bool {
    job.sample_every.is_none() && carrier(group, job.mode) == Carrier::Memory
}

/// Does one run, its messages in memory or between processes, with digests or without.
pub(crate) fn drive_on(
    job: &Job,
    carrier: Carrier,
    sealing: Sealing,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Done, Error> {
    let begun = Instant::now();
    let mut samples: Vec<Sample> = Vec::new();
    let mut next = Duration::ZERO;
    let stop = || !going_on();
    let outcome = match carrier {
        Carrier::Memory => {
            supervise::in_process::run_watched(&job.scenario, sealing, &stop, &mut |_| {})?
        }
        Carrier::SharedMemory => {
            let directory = job.record.then(Scratch::new).transpose();
            let directory = directory.map_err(MachineError::cannot("make a directory"))?;
            let keep = directory.as_ref().map(|directory| Keep {
                recording: Some(directory.path().join("topics.mcap")),
                ..Keep::default()
            });
            supervise::drive(&job.scenario, job.mode, group, keep, &mut |moment| {
                let time = Duration::from_nanos(moment.time_ns.max(0).unsigned_abs());
                if let Some(every) = job.sample_every.filter(|_| time >= next) {
                    samples.push(Sample::take());
                    next = time + every;
                }
            })?
        }
    };
    if outcome.ended == Ended::Interrupted {
        return Err(Error::Interrupted);
    }
    let summary = Summary::new(&job.scenario, job.mode, &outcome, begun.elapsed());
    let leftovers = match outcome.carrier {
        // A thread leaves nothing behind.
        Carrier::Memory => Vec::new(),
        Carrier::SharedMemory => leftovers(&outcome.root),
    };
    Ok(Done { summary, drive: outcome.drive, leftovers, samples })
}

/// A directory that is removed with its handle.
#[derive(Debug)]
pub struct Scratch {
    path: PathBuf,
}

impl Scratch {
    /// Makes one among the temporary files.
    pub fn new() -> std::io::Result<Self> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("timegap-campaign-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir(&path)?;
        Ok(Self { path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
    }
}
