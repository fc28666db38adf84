//! Strings as a study: a run is a string, driven car after car.

use super::arguments::{StringArguments, Task};
use super::cars::CarByCar;
use super::limits::{Limits, Point};
use super::results::Results;
use super::scene::Plan;
use super::wave::Driven;
use super::{page, wave};
use frame::batch::Job;
use frame::{Crew, Found, Needs, Recorded, RunOptions, Study, batch};
use report::results::Document;
use supervise::Error;

/// The study. The first string is the one of the command. Further strings drive behind a sine of each frequency. With
/// a swept key, each law alone drives behind each sine at each value.
pub struct Strings {
    task: Task,
    strings: Vec<Plan>,
    /// Frequency of each string's sine, Hz, and the value of its swept key.
    labels: Vec<[String; 2]>,
}

impl Strings {
    fn keys_of(&self, string: usize, car: usize) -> Vec<(String, String)> {
        let [hz, value] = self.labels[string].clone();
        let keys = [("vehicle".to_owned(), car.to_string()), ("frequency_hz".to_owned(), hz)];
        let swept = self.task.sweep.iter().map(|(param, _)| (param.key.clone(), value.clone()));
        keys.into_iter().chain(swept).collect()
    }
}

impl Study for Strings {
    type Arguments = StringArguments;
    type Record = Vec<Driven>;
    type Seen = ();

    const NAME: &'static str = "string";
    const NEEDS: Needs = Needs::All;

    fn plan(arguments: &StringArguments, run: &RunOptions) -> Result<Self, Error> {
        let task = Task::read(arguments, &run.group)?;
        let mut strings = vec![task.plan.clone()];
        let mut labels = vec![[String::new(), String::new()]];
        for &hz in &task.frequencies {
            strings.push(task.plan.behind_wave(hz)?);
            labels.push([hz.to_string(), String::new()]);
        }
        if let Some((param, laws)) = &task.sweep {
            let plans = laws.iter().flat_map(|law| law.plans.iter().zip(&param.settings));
            for (plan, setting) in plans {
                for &hz in &task.sweep_frequencies {
                    strings.push(plan.behind_wave(hz)?);
                    labels.push([hz.to_string(), setting.shown().1]);
                }
            }
        }
        Ok(Self { task, strings, labels })
    }

    fn runs(&self) -> usize {
        self.strings.len()
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        self.keys_of(run, 1)
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(self.task.plan.first().to_toml())
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        let plan = &self.strings[run];
        crew.steps(run, plan.vehicles);
        let mut string = CarByCar::of(plan.clone());
        for car in 1.. {
            let Some(scenario) = string.next()? else { break };
            let job = Job::lockstep(scenario);
            let done = crew.drive(run, &job)?;
            batch::whole(&done.summary)?;
            crew.observe(run, &self.keys_of(run, car), &job.scenario, &done);
            string.drove(&job.scenario, &done.summary, &done.drive);
            crew.step(run);
        }
        Ok((string.cars, ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let task = &self.task;
        let mut strings = found.records.all()?.into_iter().map(|(_, cars)| cars);
        let mut next = || strings.next().expect("the frame judges whole studies alone");
        let cars = next();
        let own = task.frequencies.iter().map(|&hz| wave::response(hz, &next())).collect();
        let mut limits = Vec::new();
        if let Some((param, laws)) = &task.sweep {
            for law in laws {
                let mut points = Vec::new();
                for setting in &param.settings {
                    let curve = task.sweep_frequencies.iter();
                    let curve = curve.map(|&hz| wave::response(hz, &next())).collect();
                    points.push(Point::new(&setting.shown().1, curve));
                }
                limits.push(Limits::new(&law.controller, &param.key, points));
            }
        }
        let results = Results::new(&task.plan, &cars, own, limits);
        let results = if task.requires_stability { results.judged_by_stability() } else { results };
        Ok(page::document(&results, &cars))
    }
}
