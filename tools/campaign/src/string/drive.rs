//! Strings on their way: each is driven car by car, several strings at a time.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};

use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use runtime::report::{ControlFigures, Outcome};
use runtime::{Carrier, Mode};
use scenario::Scenario;

use super::measure::{Measured, measure};
use super::motion::Motion;
use super::scene::{Place, Plan};
use crate::batch::{self, Done, Interrupt, ProcessesSample, Repetition};

/// Points of a trace, for the pictures.
const TRACE_POINTS: usize = 400;

/// What one car did.
#[derive(Clone, Debug)]
pub struct Driven {
    /// Where it began.
    pub place: Place,
    /// Its law.
    pub controller: String,
    /// How its drive ended.
    pub outcome: Outcome,
    /// Figures of the referee.
    pub figures: ControlFigures,
    /// Norms of its speeds and gaps.
    pub measured: Measured,
    /// Behind a sine: amplitudes of its speed and of the speed of the vehicle ahead, m/s.
    pub amplitudes: Option<[f64; 2]>,
    /// Time, s, position of its front bumper from the first car's start, m, and speed, m/s; empty
    /// behind a sine.
    pub trace: Vec<[f64; 3]>,
}

impl Driven {
    fn of(plan: &Plan, place: Place, scenario: &Scenario, done: &Done) -> Self {
        let steps = &done.drive.steps;
        let trace = match plan.wave {
            Some(_) => Vec::new(),
            None => {
                let stride = steps.len().div_ceil(TRACE_POINTS).max(1);
                let last = steps.len().saturating_sub(1);
                let kept = steps.iter().enumerate().filter(|(k, _)| k % stride == 0 || *k == last);
                kept.map(|(_, step)| {
                    [step.time_s, step.position_m - place.behind_first_m, step.speed_mps]
                })
                .collect()
            }
        };
        Self {
            place,
            controller: done.summary.controller.clone(),
            outcome: done.summary.outcome,
            figures: done.summary.control.figures.clone(),
            measured: measure(scenario, &done.drive),
            amplitudes: plan.wave.and_then(|wave| wave.amplitudes(&done.drive)),
            trace,
        }
    }
}

/// All runs of the command, of which a sample is repeated in process groups.
pub struct Drives<'a> {
    group: &'a GroupOptions,
    bar: &'a ProgressBar,
    at_once: usize,
    /// The runs to be repeated, of all.
    repeated: BTreeSet<usize>,
    sample: ProcessesSample,
    /// Runs before the next ones.
    begun: usize,
}

/// What the workers tell.
enum Told {
    /// The next car of the string of this index.
    Car(usize, Box<Driven>),
    /// What the repetition of the run of this number gave.
    Repetition(usize, Repetition),
}

impl<'a> Drives<'a> {
    /// Of `runs` runs in all, `jobs` strings at a time.
    pub fn new(
        group: &'a GroupOptions,
        bar: &'a ProgressBar,
        jobs: Option<NonZeroUsize>,
        seed: u64,
        runs: usize,
    ) -> Self {
        Self {
            group,
            bar,
            at_once: batch::at_once(jobs, Mode::Lockstep),
            repeated: batch::choose(seed, runs),
            sample: ProcessesSample::default(),
            begun: 0,
        }
    }

    /// Drives one string.
    ///
    /// # Errors
    /// As [`Drives::strings`].
    pub fn string(&mut self, plan: &Plan) -> Result<Vec<Driven>, Error> {
        Ok(self.strings(std::slice::from_ref(plan))?.pop().expect("one string, one result"))
    }

    /// Drives the strings, each car by car.
    ///
    /// # Errors
    /// What keeps a car from driving; [`Error::Interrupted`].
    pub fn strings(&mut self, plans: &[Plan]) -> Result<Vec<Vec<Driven>>, Error> {
        let interrupt = Interrupt::watch()?;
        let (stop, next) = (AtomicBool::new(false), AtomicUsize::new(0));
        let mut firsts = Vec::with_capacity(plans.len());
        let mut begun = self.begun;
        for plan in plans {
            firsts.push(begun);
            begun += plan.vehicles;
        }
        let mut driven: Vec<Vec<Driven>> = plans.iter().map(|_| Vec::new()).collect();
        let mut end = Ok(());
        let (group, repeated) = (self.group, &self.repeated);
        let (sample, bar) = (&mut self.sample, self.bar);
        let going_on = &|| !stop.load(Ordering::Relaxed) && !interrupt.came();
        std::thread::scope(|scope| {
            let (sender, results) = sync_channel::<Result<Told, Error>>(self.at_once);
            for _ in 0..self.at_once.min(plans.len()) {
                let (sender, firsts, next) = (sender.clone(), &firsts, &next);
                scope.spawn(move || {
                    while going_on() {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(plan) = plans.get(index) else { return };
                        // Beside the string: the next car does not wait for it.
                        let repeat = |car: usize, scenario: &Scenario, done: &Done| {
                            let number = firsts[index] + car;
                            if !repeated.contains(&number)
                                || done.summary.carrier != Carrier::Memory
                            {
                                return;
                            }
                            let (scenario, summary) = (scenario.clone(), done.summary.clone());
                            let sender = sender.clone();
                            scope.spawn(move || {
                                let found = batch::repeat(&scenario, &summary, group, going_on);
                                let _ = sender.send(found.map(|r| Told::Repetition(number, r)));
                            });
                        };
                        let string = One { index, plan, group, repeat: &repeat };
                        if let Err(error) = string.drive(going_on, &sender) {
                            // The receiver is there until all senders are gone.
                            let _ = sender.send(Err(error));
                        }
                    }
                });
            }
            drop(sender);
            for result in results {
                match result {
                    Ok(Told::Car(string, car)) => {
                        driven[string].push(*car);
                        bar.inc(1);
                    }
                    Ok(Told::Repetition(number, found)) => sample.count(number, Some(&found)),
                    Err(error) => {
                        stop.store(true, Ordering::Relaxed);
                        end = std::mem::replace(&mut end, Ok(())).and(Err(error));
                    }
                }
            }
        });
        self.begun = begun;
        if interrupt.came() {
            return Err(Error::Interrupted);
        }
        end.map(|()| driven)
    }

    /// What came of the repeated runs.
    pub fn into_sample(self) -> ProcessesSample {
        self.sample
    }
}

/// One string.
struct One<'a> {
    index: usize,
    plan: &'a Plan,
    group: &'a GroupOptions,
    /// Repeats a car's run in a process group, if it is chosen for that.
    repeat: &'a dyn Fn(usize, &Scenario, &Done),
}

impl One<'_> {
    fn drive(
        &self,
        going_on: &dyn Fn() -> bool,
        results: &SyncSender<Result<Told, Error>>,
    ) -> Result<(), Error> {
        let mut place = Place::default();
        let mut scenario = self.plan.first();
        loop {
            let done = batch::lockstep(&scenario, self.group, false, going_on)?;
            batch::whole(&done.summary)?;
            (self.repeat)(place.index, &scenario, &done);
            let motion = Motion::of(&scenario, &done.drive, done.summary.outcome);
            let car = Driven::of(self.plan, place, &scenario, &done);
            if results.send(Ok(Told::Car(self.index, Box::new(car)))).is_err()
                || place.index + 1 == self.plan.vehicles
            {
                return Ok(());
            }
            (scenario, place) = self.plan.behind(place, &motion)?;
        }
    }
}
