//! Strings as a study: car by car, several cars at a time.
//!
//! The workers take the cars in their order. In one process a car drives a moment behind the one before it
//! ([`super::growing`]). In process groups each waits for the whole motion of that one.

use std::sync::Arc;

use frame::batch::{self, Done};
use frame::keep::Keep;
use frame::{Crew, Found, Needs, Options, RunResult, Study};
use group::Error;
use group::in_process::Ahead;
use report::results::Document;
use runtime::{Carrier, Sealing};
use scenario::Scenario;

use super::arguments::{StringArguments, Task};
use super::driven::Driven;
use super::growing::{Giver, Growing};
use super::limits::{Limits, Point};
use super::motion::Motion;
use super::results::Results;
use super::scene::{Place, Plan};
use super::{page, response};

/// The study: every car of every string is a run.
///
/// The first string is the one of the command. Further strings drive behind a sine of each frequency. With a swept
/// key, each law alone drives behind each sine at each value.
pub struct Strings {
    task: Task,
    strings: Vec<Plan>,
    /// Frequency of each string's sine, Hz, and the value of its swept key.
    labels: Vec<[String; 2]>,
    cars: Vec<Car>,
}

impl Study for Strings {
    type Arguments = StringArguments;
    type Record = ();
    type Seen = Driven;

    const NAME: &'static str = "string";
    const NEEDS: Needs = Needs::All;

    fn options(arguments: &StringArguments) -> Options<'_> {
        let StringArguments { jobs, group, results, .. } = arguments;
        Options { parts: None, jobs: *jobs, group, results }
    }

    fn plan(arguments: &StringArguments) -> Result<Self, Error> {
        let task = Task::read(arguments)?;
        let mut strings = vec![task.plan.clone()];
        let mut labels = vec![[String::new(), String::new()]];
        for &hz in &task.frequencies {
            strings.push(task.plan.behind_wave(hz)?);
            labels.push([hz.to_string(), String::new()]);
        }
        if let Some((param, laws)) = &task.sweep {
            let plans = laws.iter().flat_map(|law| law.plans.iter().zip(&param.values));
            for (plan, value) in plans {
                for &hz in &task.sweep_frequencies {
                    strings.push(plan.behind_wave(hz)?);
                    labels.push([hz.to_string(), value.clone()]);
                }
            }
        }
        let cars = strings.iter().enumerate().flat_map(|(string, plan)| Car::all(string, plan));
        let cars = cars.collect();
        Ok(Self { task, strings, labels, cars })
    }

    fn runs(&self) -> usize {
        self.cars.len()
    }

    fn seed(&self) -> u64 {
        self.task.plan.seed()
    }

    fn keep(arguments: &StringArguments) -> Option<Keep> {
        arguments.keep
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let Car { string, place, .. } = &self.cars[run];
        let [hz, value] = self.labels[*string].clone();
        let keys = [
            ("vehicle".to_owned(), (place.index + 1).to_string()),
            ("frequency_hz".to_owned(), hz),
        ];
        let swept = self.task.sweep.iter().map(|(param, _)| (param.key.clone(), value.clone()));
        keys.into_iter().chain(swept).collect()
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(self.task.plan.first().to_toml())
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Result<RunResult<(), Driven>, Error> {
        let car = &self.cars[run];
        let plan = &self.strings[car.string];
        // However it ends, the car behind does not wait for it any longer.
        let _closed = Closed(&car.growing);
        // Digests are there to be compared.
        let repeats = crew.repeats(run);
        let sealing = if repeats { Sealing::Sealed } else { Sealing::Unsealed };
        let (scenario, done) = car.drive(plan, crew, sealing)?;
        crew.observe(run, &self.keys(run), &scenario, &done);
        let seen = Driven::of(plan, car.place, &scenario, &done);
        let repetition = match repeats && done.summary.carrier == Carrier::Memory {
            true => Some(batch::repeat(&scenario, &done.summary, crew.group(), crew.going_on())?),
            false => None,
        };
        Ok(RunResult { record: (), seen, repetition })
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let task = &self.task;
        let mut driven = found.seen.into_values();
        let mut strings =
            self.strings.iter().map(|plan| driven.by_ref().take(plan.vehicles).collect::<Vec<_>>());
        let mut next = || strings.next().expect("every string was driven");
        let cars = next();
        let own = task.frequencies.iter().map(|&hz| response::response(hz, &next())).collect();
        let mut limits = Vec::new();
        if let Some((param, laws)) = &task.sweep {
            for law in laws {
                let mut points = Vec::new();
                for value in &param.values {
                    let curve = task.sweep_frequencies.iter();
                    let curve = curve.map(|&hz| response::response(hz, &next())).collect();
                    points.push(Point::new(value, curve));
                }
                limits.push(Limits::new(&law.controller, &param.key, points));
            }
        }
        let results = Results::new(&task.plan, &cars, own, limits, found.sample);
        let results = if task.requires_stability { results.judged_by_stability() } else { results };
        Ok(page::document(&results, &cars))
    }
}

/// A car of a string.
struct Car {
    /// Its string.
    string: usize,
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

impl Car {
    fn all(string: usize, plan: &Plan) -> Vec<Self> {
        let mut last = None;
        let car = |place| {
            let growing = Arc::<Growing>::default();
            let before = last.replace(Arc::clone(&growing));
            Self { string, place, before, growing }
        };
        plan.places().into_iter().map(car).collect()
    }

    /// The scenario with the whole motion of the car before, and its drive.
    fn drive(
        &self,
        plan: &Plan,
        crew: &Crew<'_>,
        sealing: Sealing,
    ) -> Result<(Scenario, Done), Error> {
        let (scenario, done) = match &self.before {
            None => {
                let scenario = plan.first();
                let done = self.run(&scenario, crew, sealing, nothing_new(), crew.going_on())?;
                (scenario, done)
            }
            Some(before) => {
                let driven = self.drive_behind(plan, before, crew, sealing)?;
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
        plan: &Plan,
        before: &Arc<Growing>,
        crew: &Crew<'_>,
        sealing: Sealing,
    ) -> Result<(Scenario, Done), Error> {
        let whole = || before.whole().ok_or(Error::Interrupted);
        let going_on = crew.going_on();
        if batch::in_one_thread(crew.group())
            && let Some(start) = before.start()
        {
            let scenario = plan.behind(self.place, &start)?;
            let while_it_counts = || going_on() && !before.is_revoked();
            let done = self.run(&scenario, crew, sealing, before.ahead(), &while_it_counts);
            let motion = whole()?;
            if !before.is_revoked() {
                return Ok((plan.behind(self.place, &motion)?, done?));
            }
            self.growing.revoke();
        }
        let scenario = plan.behind(self.place, &whole()?)?;
        let done = self.run(&scenario, crew, sealing, nothing_new(), going_on)?;
        Ok((scenario, done))
    }

    fn run(
        &self,
        scenario: &Scenario,
        crew: &Crew<'_>,
        sealing: Sealing,
        ahead: Ahead,
        going_on: &dyn Fn() -> bool,
    ) -> Result<Done, Error> {
        if !batch::in_one_thread(crew.group()) {
            return batch::lockstep(scenario, crew.group(), false, going_on);
        }
        let mut giver = Giver::new(&self.growing, scenario);
        batch::lockstep_behind(scenario, sealing, ahead, going_on, &mut |moment| {
            giver.watch(moment)
        })
    }
}

/// Makes it for a table that is whole from the start.
fn nothing_new() -> Ahead {
    Box::new(|_, _| {})
}
