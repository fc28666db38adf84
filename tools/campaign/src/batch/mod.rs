//! Many runs through real process groups, several at a time.
//!
//! Each worker is a thread that launches one group after the other. An interrupt reaches every
//! group that is up and keeps further ones from being launched; what finished before is kept.

mod leftovers;
mod usage;

pub use usage::Growth;

use group::Error;
use group::GroupOptions;
use group::{Drive, Ended};

use indicatif::ProgressBar;
use leftovers::leftovers;
use report::summary::Summary;
use runtime::Mode;
use scenario::Scenario;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};
use usage::Sample;

/// A run to be done.
#[derive(Debug)]
pub struct Job {
    /// What happens in it.
    pub scenario: Scenario,
    /// Clock.
    pub mode: Mode,
    /// Time between two samples of what the run's processes have; none: no samples.
    pub sample_every: Option<Duration>,
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
}

/// How many runs go on at once: so many as chosen, or as there are cores; in realtime one, since
/// runs that share cores would measure each other.
pub fn at_once(chosen: Option<NonZeroUsize>, mode: Mode) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    chosen.map_or_else(|| if mode == Mode::Realtime { 1 } else { cores() }, NonZeroUsize::get)
}

/// Does the jobs, `at_once` at a time, in their order. `each` gets every run's index and result as
/// it ends, in this thread; a run that could not be brought up is a result too. An error that `each`
/// returns ends the batch.
///
/// # Errors
/// [`Error::Interrupted`] when a signal asked for the end, what keeps every run from starting, or what
/// `each` returned; in each case when all groups are gone.
pub fn run(
    jobs: &[Job],
    at_once: usize,
    group: &GroupOptions,
    bar: &ProgressBar,
    each: &mut dyn FnMut(usize, Result<Done, Error>) -> Result<(), Error>,
) -> Result<(), Error> {
    let interrupt = Interrupt::watch()?;
    let stop = AtomicBool::new(false);
    let next = AtomicUsize::new(0);
    let mut end = Ok(());
    std::thread::scope(|scope| {
        let (sender, results) = channel();
        for _ in 0..at_once.min(jobs.len()) {
            let sender = sender.clone();
            let going_on = || !stop.load(Ordering::Relaxed) && !interrupt.came();
            let next = &next;
            scope.spawn(move || work(jobs, next, group, &going_on, &sender));
        }
        drop(sender);
        for (index, result) in results {
            let taken = match result {
                // What befell this run alone is its result.
                Ok(_) | Err(Error::NotReady { .. } | Error::Runtime(_)) => each(index, result),
                Err(error) => Err(error),
            };
            match taken {
                Ok(()) => bar.inc(1),
                Err(error) => {
                    stop.store(true, Ordering::Relaxed);
                    end = std::mem::replace(&mut end, Ok(())).and(Err(error));
                }
            }
        }
    });
    if interrupt.came() { Err(Error::Interrupted) } else { end }
}

fn work(
    jobs: &[Job],
    next: &AtomicUsize,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
    results: &Sender<(usize, Result<Done, Error>)>,
) {
    while going_on() {
        let index = next.fetch_add(1, Ordering::Relaxed);
        let Some(job) = jobs.get(index) else { return };
        if results.send((index, drive(job, group))).is_err() {
            return;
        }
    }
}

fn drive(job: &Job, group: &GroupOptions) -> Result<Done, Error> {
    let begun = Instant::now();
    let mut samples: Vec<Sample> = Vec::new();
    let mut next = Duration::ZERO;
    let outcome = group::drive(&job.scenario, job.mode, group, None, &mut |moment| {
        let time = Duration::from_nanos(moment.time_ns.max(0).unsigned_abs());
        if let Some(every) = job.sample_every.filter(|_| time >= next) {
            samples.push(Sample::take());
            next = time + every;
        }
    })?;
    if outcome.ended == Ended::Interrupted {
        return Err(Error::Interrupted);
    }
    let summary = Summary::new(&job.scenario, job.mode, &outcome, begun.elapsed());
    let leftovers = leftovers(&outcome.root);
    Ok(Done { summary, drive: outcome.drive, leftovers, samples })
}

/// Notices the signals that ask for an end also between two groups, when no group listens.
struct Interrupt {
    came: Arc<AtomicBool>,
    registered: Vec<signal_hook::SigId>,
}

impl Interrupt {
    fn watch() -> Result<Self, Error> {
        let came = Arc::new(AtomicBool::new(false));
        let registered = group::end_signals()
            .into_iter()
            .map(|signal| signal_hook::flag::register(signal, Arc::clone(&came)))
            .collect::<Result<_, _>>()
            .map_err(|e| Error::Machine(format!("cannot handle signals: {e}")))?;
        Ok(Self { came, registered })
    }

    fn came(&self) -> bool {
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
