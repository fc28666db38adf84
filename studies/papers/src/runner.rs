//! Drives scenarios in lockstep, as many at a time as there are cores.

use super::Gallery;
use frame::batch::{self, Interrupt, OtherBytes, ProcessesSample};
use group::{Drive, Error, GroupOptions, ScenarioOptions};
use indicatif::ProgressBar;
use report::RunPicture;
use report::summary::Summary;
use scenario::Scenario;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// A scenario that was driven in lockstep.
pub struct Driven {
    /// The scenario as it took effect.
    pub scenario: Scenario,
    /// The recorded drive.
    pub drive: Drive,
    /// Its summary.
    pub summary: Summary,
    /// Names of the law's figures in the drive.
    pub figure_names: Vec<&'static str>,
}

impl Driven {
    /// One of the law's figures over the control cycles: (time in s, value).
    pub fn figure(&self, name: &str) -> Vec<(f64, f64)> {
        let index = self.figure_names.iter().position(|figure| *figure == name);
        let index = index.expect("the law has a figure of this name");
        self.drive
            .steps
            .iter()
            .filter_map(|step| step.figures.map(|figures| (step.time_s, figures[index])))
            .collect()
    }

    /// Its picture, under the scenario's and the controller's names.
    pub fn picture(&self) -> (String, RunPicture) {
        let scenario = &self.scenario;
        let name = format!("{} · {}", scenario.name.as_str(), scenario.controller.name.as_str());
        (name, RunPicture::of_drive(scenario, &self.drive))
    }
}

/// Shared state of all parts of a reproduction.
pub struct Runner<'a> {
    group: &'a GroupOptions,
    cores: Cores,
    bar: ProgressBar,
    /// Set once a run failed or was interrupted: no further run is begun.
    stopped: AtomicBool,
    interrupt: Interrupt,
    /// Standard deviation of the skilled driver's aimed speed, m/s.
    driver_spread_mps: f64,
    /// Runs begun so far, of how many.
    begun: AtomicUsize,
    runs: usize,
    /// Which of them are repeated in process groups, and what came of it.
    repeated: BTreeSet<usize>,
    sample: Mutex<ProcessesSample>,
}

/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;

/// Result of a paper's part of the reproduction.
#[derive(Default)]
pub struct Part {
    /// The rows.
    pub rows: Vec<super::row::Row>,
    /// The drives to be shown, by their names.
    pub drives: Vec<(String, RunPicture)>,
    /// Pictures of the paper's own.
    pub pictures: Vec<Gallery>,
}

impl Part {
    /// Adds what another part gave.
    pub fn extend(&mut self, other: Self) {
        self.rows.extend(other.rows);
        self.drives.extend(other.drives);
        self.pictures.extend(other.pictures);
    }
}

impl<'a> Runner<'a> {
    /// A runner on all cores with a bar over `runs` runs.
    pub fn new(group: &'a GroupOptions, runs: usize, quiet: bool) -> Result<Self, Error> {
        let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let bar = report::progress::count_bar(runs, quiet);
        Ok(Self {
            group,
            cores: Cores::new(cores),
            bar,
            stopped: AtomicBool::new(false),
            driver_spread_mps: 2.5 / 3.6,
            interrupt: Interrupt::watch()?,
            begun: AtomicUsize::new(0),
            runs,
            repeated: batch::choose(SAMPLE_SEED, runs),
            sample: Mutex::default(),
        })
    }

    /// The same with another skilled driver: the standard deviation of the aimed speed, m/s.
    pub fn with_driver_spread(self, driver_spread_mps: f64) -> Self {
        Self { driver_spread_mps, ..self }
    }

    /// Standard deviation of the skilled driver's aimed speed, m/s.
    pub fn driver_spread_mps(&self) -> f64 {
        self.driver_spread_mps
    }

    /// Drives a built-in scenario with these keys set, once a core is free.
    pub fn drive(&self, name: &str, keys: &[&str]) -> Result<Driven, Error> {
        let options = ScenarioOptions {
            set: keys.iter().map(ToString::to_string).collect(),
            ..ScenarioOptions::default()
        };
        let scenario = group::open(name, &options)?;
        let driven = self.cores.occupy(|| {
            let going_on = || !self.stopped.load(Ordering::Relaxed) && !self.interrupt.came();
            if !going_on() {
                return Err(Error::Interrupted);
            }
            self.bar.set_message(name.to_owned());
            let index = self.begun.fetch_add(1, Ordering::Relaxed);
            let repeat = self.repeated.contains(&index);
            let done = batch::lockstep(&scenario, self.group, repeat, &going_on)?;
            batch::whole(&done.summary)?;
            self.sample
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .count(index, done.repetition.as_ref());
            self.bar.inc(1);
            let figure_names = controller::laws::figure_names(&scenario);
            let (drive, summary) = (done.drive, done.summary);
            Ok(Driven { scenario: scenario.clone(), drive, summary, figure_names })
        });
        if driven.is_err() {
            self.stopped.store(true, Ordering::Relaxed);
        }
        driven
    }

    /// Computes something without a process group, once a core is free.
    pub fn compute<T>(&self, work: impl FnOnce() -> T) -> T {
        let result = self.cores.occupy(work);
        self.bar.tick();
        result
    }

    /// Removes the bar and returns the comparison of the repeated runs.
    ///
    /// # Errors
    /// [`OtherBytes`] if one of them gave other bytes.
    pub fn finish(self) -> Result<ProcessesSample, OtherBytes> {
        let sample = self.sample.into_inner().unwrap_or_else(PoisonError::into_inner);
        sample.print(self.runs, &self.bar);
        self.bar.finish_and_clear();
        sample.agreed(|_| String::new())
    }
}

/// Does all tasks at once, each in a thread of its own; what they give, in their order. How many of
/// them work at a time is for [`Runner`] to say.
pub fn together<T, F>(tasks: impl IntoIterator<Item = F>) -> Vec<T>
where
    T: Send,
    F: FnOnce() -> T + Send,
{
    std::thread::scope(|scope| {
        let threads: Vec<_> = tasks.into_iter().map(|task| scope.spawn(task)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// A number of places for work that keeps a core busy.
struct Cores {
    free: Mutex<usize>,
    freed: Condvar,
}

impl Cores {
    fn new(count: usize) -> Self {
        Self { free: Mutex::new(count), freed: Condvar::new() }
    }

    /// Waits for a place and works in it.
    fn occupy<T>(&self, work: impl FnOnce() -> T) -> T {
        {
            let free = self.free();
            let mut free = self
                .freed
                .wait_while(free, |free| *free == 0)
                .unwrap_or_else(PoisonError::into_inner);
            *free -= 1;
        }
        let _place = Place(self);
        work()
    }

    fn free(&self) -> MutexGuard<'_, usize> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A place that is given back, after a panic too.
struct Place<'a>(&'a Cores);

impl Drop for Place<'_> {
    fn drop(&mut self) {
        *self.0.free() += 1;
        self.0.freed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn results_keep_the_order_of_their_tasks() {
        let tasks = (0..20).map(|index| move || index * index);
        assert_eq!(together(tasks), (0..20).map(|index| index * index).collect::<Vec<_>>());
    }

    #[test]
    fn no_more_work_goes_on_than_there_are_places() {
        let cores = Cores::new(2);
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let task = || {
            cores.occupy(|| {
                most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                std::thread::yield_now();
                now.fetch_sub(1, Ordering::SeqCst);
            });
        };
        together((0..16).map(|_| task));
        assert!((1..=2).contains(&most.into_inner()));
        assert_eq!(*cores.free(), 2, "all places are free again");
    }

    #[test]
    fn a_panic_gives_its_place_back() {
        let cores = Cores::new(1);
        let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            cores.occupy(|| panic!("as a test"));
        }));
        assert!(panicked.is_err());
        assert_eq!(cores.occupy(|| 7), 7);
    }
}
