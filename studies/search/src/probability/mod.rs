//! `--probability`: how often a requirement is broken when the variables follow given distributions.
//!
//! ```text
//! unit 0 … 4       a replica of cross-entropy importance sampling each   half the budget
//! unit 5 … m       50 points of Monte Carlo each                         the other half, or as many as the file says
//! unit m + 1 …     5 rows of Sobol's indices each                        beside the budget, if asked for
//! ```
//!
//! A unit is a run of the frame. It is driven in one thread and kept in one line of the journal. A replica has thousands
//! of points: it also keeps its values as they come, and goes on from them after an interrupt. A point that the
//! reference driver does not avoid is not a failure and costs no drive. Every drive has a seed of its own, so that
//! noise is a part of the probability.

mod model;
mod results;
mod unit;

pub use unit::Unit;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Mutex;

use frame::batch::Job;
use frame::keep::Keep;
use frame::{Crew, Found, Needs, Recorded, RunOptions, Study};
use rare_events::{Budget, REPLICAS, replica, sobol};
use report::results::Document;
use supervise::{Error, UsageError};

use crate::SearchArguments;
use crate::method::seed_of;
use crate::problem::{Problem, Value};
use crate::record::judge;
use model::Model;
use unit::{Kind, Units};

/// Points of a unit that are kept at once: more than a unit of Monte Carlo has.
const KEPT_AT_ONCE: usize = 100;

pub struct Probability {
    problem: Problem,
    model: Model,
    units: Units,
    seed: u64,
    /// Events of the units of Monte Carlo that ended.
    events: Mutex<BTreeMap<usize, usize>>,
}

impl Study for Probability {
    type Arguments = SearchArguments;
    type Record = Unit;
    type Seen = ();

    const NAME: &'static str = "search-probability";
    const NEEDS: Needs = Needs::All;

    fn plan(arguments: &SearchArguments, run: &RunOptions) -> Result<Self, Error> {
        if run.keep == Some(Keep::All) {
            let why = "a unit of --probability holds too many drives for memory";
            return Err(UsageError::at("--keep all", why, "failures or worst:N").into());
        }
        let problem = Problem::open(arguments, &run.group)?;
        let model = Model::of(&problem)?;
        let units = Units::new(arguments.budget.get(), model.monte_carlo, model.rows());
        let seed = arguments.seed()?;
        Ok(Self { problem, model, units, seed, events: Mutex::default() })
    }

    fn runs(&self) -> usize {
        self.units.count()
    }

    fn label(&self) -> String {
        format!("probability-{}", self.problem.name)
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(format!("{}\n{:?}", self.problem.subject(), self.model))
    }

    fn recall(&self, run: usize, unit: &Unit) {
        self.tell(run, unit);
    }

    fn keys(&self, _: usize) -> Vec<(String, String)> {
        self.problem.named(&self.problem.middle())
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        crew.steps(run, self.units.points(run, self.problem.dimensions()));
        let mut points = Points {
            study: self,
            run,
            crew,
            unit: Unit::default(),
            known: crew.recalled(run).into(),
            fresh: Vec::new(),
        };
        match self.units.kind(run) {
            Kind::Replica { number, runs } => {
                let budget = Budget { runs, seed: seed_of(self.seed, 8, 0) };
                let dimensions = self.problem.dimensions();
                let found = replica(dimensions, budget, number, &mut |u| points.value(u))?;
                points.unit.take(found);
            }
            Kind::MonteCarlo { .. } if self.has_enough(run) => {}
            Kind::MonteCarlo { first, count } => {
                for number in first..first + count {
                    let seed = seed_of(self.seed, 9, 0);
                    let point = rare_events::point(self.problem.dimensions(), seed, number as u64);
                    if points.value(&point)? < 0.0 {
                        points.unit.events.push(point);
                    }
                }
            }
            Kind::Rows { first, count } => {
                for number in first..first + count {
                    let seed = seed_of(self.seed, 10, 0);
                    let row = sobol::row(self.problem.dimensions(), seed, number as u64);
                    let values = row.iter().map(|point| points.value(point));
                    let values = values.collect::<Result<_, _>>()?;
                    points.unit.rows.push(values);
                }
            }
        }
        let unit = points.unit;
        self.tell(run, &unit);
        Ok((unit, ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let units: Vec<Unit> = found.records.all()?.into_iter().map(|(_, unit)| unit).collect();
        let answer = results::Answer::of(&self.units, &self.model, &units);
        Ok(answer.document(&self.problem, &self.model))
    }
}

impl Probability {
    fn tell(&self, run: usize, unit: &Unit) {
        if matches!(self.units.kind(run), Kind::MonteCarlo { .. }) {
            self.events.lock().expect("no worker panics here").insert(run, unit.events.len());
        }
    }

    /// The units of Monte Carlo before this one have all ended, with enough events: the answer does not need it.
    fn has_enough(&self, run: usize) -> bool {
        let events = self.events.lock().expect("no worker panics here");
        let before = REPLICAS..run;
        let is_known = before.clone().all(|unit| events.contains_key(&unit));
        is_known
            && events.range(before).map(|(_, count)| count).sum::<usize>() >= self.units.enough()
    }
}

/// Evaluates the points of a unit.
struct Points<'a> {
    study: &'a Probability,
    run: usize,
    crew: &'a Crew<'a>,
    unit: Unit,
    /// Values of the next points, from before an interrupt.
    known: VecDeque<f64>,
    /// Values that are not kept yet.
    fresh: Vec<f64>,
}

impl Points<'_> {
    /// The value of a point, as a search has it. It is a step of the unit.
    fn value(&mut self, point: &[f64]) -> Result<f64, Error> {
        let known = self.known.pop_front();
        let value = self.evaluate(point, known)?;
        self.crew.step(self.run);
        if known.is_none() {
            self.fresh.push(value);
        }
        // A unit of Monte Carlo is short enough to be done again.
        if self.fresh.len() >= KEPT_AT_ONCE {
            self.crew.keep(self.run, &self.fresh)?;
            self.fresh.clear();
        }
        Ok(value)
    }

    fn evaluate(&mut self, point: &[f64], known: Option<f64>) -> Result<f64, Error> {
        let Probability { problem, model, seed, .. } = self.study;
        let (values, is_clipped): (Vec<Value>, bool) = model.values(problem, point);
        self.unit.clipped += usize::from(is_clipped);
        let number = self.unit.points as u64;
        self.unit.points += 1;
        let scenario = problem.scenario(&values, seed_of(*seed, 11 + self.run as u64, number))?;
        let reference = problem.by_reference(&scenario);
        if reference >= 0.0 {
            return Ok(reference);
        }
        if let Some(value) = known {
            self.unit.driven += 1;
            return Ok(value);
        }
        let job = Job::lockstep(scenario);
        let done = self.crew.drive(self.run, &job)?;
        self.crew.observe(self.run, &problem.named(&values), &job.scenario, &done);
        self.unit.driven += 1;
        Ok(judge(&done.summary).robustness.max(reference))
    }
}
