//! Strings on their way: car by car, several cars at a time.
//!
//! The workers take the cars in their order. In one process a car drives a moment behind the one before it
//! ([`super::growing`]); in process groups each waits for the whole motion of that one.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

use group::in_process::Ahead;
use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use runtime::report::{ControlFigures, Outcome};
use runtime::{Carrier, Mode, Sealing};
use scenario::Scenario;

use super::growing::{Giver, Growing};
use super::measure::{Measured, measure};
use super::motion::Motion;
use super::scene::{Place, Plan};
use super::wave::Amplitudes;
use frame::batch::{self, Done, Interrupt, ProcessesSample, Repetition};

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
    /// What it made of a sine.
    pub amplitudes: Option<Amplitudes>,
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
    /// What the car of this number did.
    Car(usize, Box<Driven>),
    /// What the repetition of the run of this number gave.
    Repetition(usize, Repetition),
}

impl<'a> Drives<'a> {
    /// Of `runs` runs in all, `jobs` cars at a time.
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
        let cars: Vec<Car<'_>> = plans.iter().flat_map(Car::all).collect();
        let mut driven: Vec<Option<Driven>> = cars.iter().map(|_| None).collect();
        let mut end = Ok(());
        let (group, repeated, first) = (self.group, &self.repeated, self.begun);
        let (sample, bar) = (&mut self.sample, self.bar);
        let going_on = &|| !stop.load(Ordering::Relaxed) && !interrupt.came();
        std::thread::scope(|scope| {
            let (sender, results) = sync_channel::<Result<Told, Error>>(self.at_once);
            for _ in 0..self.at_once.min(cars.len()) {
                let (sender, cars, next) = (sender.clone(), &cars, &next);
                scope.spawn(move || {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(car) = cars.get(index) else { return };
                        // However it ends, the car behind does not wait for it any longer.
                        let _closed = Closed(&car.growing);
                        if !going_on() {
                            continue;
                        }
                        // Digests are there to be compared.
                        let sealing = match repeated.contains(&(first + index)) {
                            true => Sealing::Sealed,
                            false => Sealing::Unsealed,
                        };
                        let told = car.drive(group, sealing, going_on).map(|(scenario, done)| {
                            let own = Driven::of(car.plan, car.place, &scenario, &done);
                            let (number, summary) = (first + index, done.summary);
                            if repeated.contains(&number) && summary.carrier == Carrier::Memory {
                                // Beside the string: the next car does not wait for it.
                                let sender = sender.clone();
                                scope.spawn(move || {
                                    let found = batch::repeat(&scenario, &summary, group, going_on);
                                    let _ = sender.send(found.map(|r| Told::Repetition(number, r)));
                                });
                            }
                            Told::Car(index, Box::new(own))
                        });
                        // The receiver is there until all senders are gone.
                        let _ = sender.send(told);
                    }
                });
            }
            drop(sender);
            for result in results {
                match result {
                    Ok(Told::Car(index, car)) => {
                        driven[index] = Some(*car);
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
        self.begun += cars.len();
        if interrupt.came() {
            return Err(Error::Interrupted);
        }
        end?;
        let mut driven =
            driven.into_iter().map(|car| car.expect("without an error all were driven"));
        Ok(plans.iter().map(|plan| driven.by_ref().take(plan.vehicles).collect()).collect())
    }

    /// What came of the repeated runs.
    pub fn into_sample(self) -> ProcessesSample {
        self.sample
    }
}

/// A car of a string.
struct Car<'a> {
    plan: &'a Plan,
    place: Place,
    /// The motion of the car before it.
    before: Option<Arc<Growing>>,
    /// Its own.
    growing: Arc<Growing>,
}

/// Closes a motion when its drive is over.
struct Closed<'a>(&'a Growing);

impl Drop for Closed<'_> {
    fn drop(&mut self) {
        self.0.close();
    }
}

impl<'a> Car<'a> {
    fn all(plan: &'a Plan) -> Vec<Self> {
        let mut last = None;
        let car = |place| {
            let growing = Arc::<Growing>::default();
            let before = last.replace(Arc::clone(&growing));
            Self { plan, place, before, growing }
        };
        plan.places().into_iter().map(car).collect()
    }

    /// The scenario, with the whole motion of the car before, and what came of it.
    fn drive(
        &self,
        group: &GroupOptions,
        sealing: Sealing,
        going_on: &dyn Fn() -> bool,
    ) -> Result<(Scenario, Done), Error> {
        let (scenario, done) = match &self.before {
            None => {
                let scenario = self.plan.first();
                let done = self.run(&scenario, group, sealing, nothing_new(), going_on)?;
                (scenario, done)
            }
            Some(before) => {
                let driven = self.drive_behind(before, group, sealing, going_on)?;
                before.forget();
                driven
            }
        };
        batch::whole(&done.summary)?;
        self.growing.finish(Motion::of(&scenario, &done.drive, done.summary.outcome));
        Ok((scenario, done))
    }

    fn drive_behind(
        &self,
        before: &Arc<Growing>,
        group: &GroupOptions,
        sealing: Sealing,
        going_on: &dyn Fn() -> bool,
    ) -> Result<(Scenario, Done), Error> {
        let whole = || before.whole().ok_or(Error::Interrupted);
        if batch::in_one_thread(group)
            && let Some(start) = before.start()
        {
            let scenario = self.plan.behind(self.place, &start)?;
            let while_it_counts = || going_on() && !before.is_revoked();
            let done = self.run(&scenario, group, sealing, before.ahead(), &while_it_counts);
            let motion = whole()?;
            if !before.is_revoked() {
                return Ok((self.plan.behind(self.place, &motion)?, done?));
            }
            self.growing.revoke();
        }
        let scenario = self.plan.behind(self.place, &whole()?)?;
        let done = self.run(&scenario, group, sealing, nothing_new(), going_on)?;
        Ok((scenario, done))
    }

    fn run(
        &self,
        scenario: &Scenario,
        group: &GroupOptions,
        sealing: Sealing,
        ahead: Ahead,
        going_on: &dyn Fn() -> bool,
    ) -> Result<Done, Error> {
        if !batch::in_one_thread(group) {
            return batch::lockstep(scenario, group, false, going_on);
        }
        let mut giver = Giver::new(&self.growing, scenario);
        batch::lockstep_behind(scenario, sealing, ahead, going_on, &mut |moment| {
            giver.watch(moment)
        })
    }
}

/// For a table that is whole from the start.
fn nothing_new() -> Ahead {
    Box::new(|_, _| {})
}
