//! Many lockstep runs in this process, each in a thread of its own.

use super::Interrupt;
use group::{Drive, Ended, Error, in_process};
use indicatif::ProgressBar;
use scenario::Scenario;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// Runs the scenarios in lockstep, `at_once` at a time, their messages in memory. `each` gets every
/// run's index and drive as it ends, in this thread; an error that it returns ends the batch.
///
/// # Errors
/// [`Error::Interrupted`] when a signal asked for the end, what keeps a run from going on, or what
/// `each` returned.
pub fn run_in_memory(
    scenarios: &[Scenario],
    at_once: usize,
    bar: &ProgressBar,
    each: &mut dyn FnMut(usize, Drive) -> Result<(), Error>,
) -> Result<(), Error> {
    let interrupt = Interrupt::watch()?;
    let stop = AtomicBool::new(false);
    let next = AtomicUsize::new(0);
    let mut end = Ok(());
    std::thread::scope(|scope| {
        let (sender, results) = channel();
        for _ in 0..at_once.min(scenarios.len()) {
            let sender = sender.clone();
            let ends = || stop.load(Ordering::Relaxed) || interrupt.came();
            let next = &next;
            scope.spawn(move || {
                while !ends() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(scenario) = scenarios.get(index) else { return };
                    if sender.send((index, drive(scenario, &ends))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (index, result) in results {
            match result.and_then(|drive| each(index, drive)) {
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

fn drive(scenario: &Scenario, ends: &dyn Fn() -> bool) -> Result<Drive, Error> {
    let outcome = in_process::run_watched(scenario, ends, &mut |_| {})?;
    match outcome.ended {
        Ended::Orderly => Ok(outcome.drive),
        Ended::Interrupted => Err(Error::Interrupted),
        Ended::Broken { service, how } => {
            Err(Error::NotReady { service, what: how, foreign: false })
        }
        Ended::GivenUp { service, restarts } => {
            let what = format!("was given up after {restarts} restarts");
            Err(Error::NotReady { service, what, foreign: false })
        }
    }
}
