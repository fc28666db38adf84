//! Minimal cases: a failure that departs from the nominal values as little as it can.
//!
//! ```text
//! for each variable: nominal? ─ else halve the way to it, thrice ─ then fewest digits
//! ```
//!
//! Each change is kept if the failure still holds on 8 of 10 seeds. One seed is not enough. Noise turns verdicts near
//! the limit, and a case that was reduced on one seed holds on few others.

use std::num::NonZeroUsize;
use std::sync::Mutex;

use frame::RunOptions;
use frame::batch::{self, Done};
use indicatif::ProgressBar;
use runtime::Mode;
use scenario::Scenario;
use supervise::{Error, GroupOptions, UsageError};

use crate::SearchArguments;
use crate::method::seed_of;
use crate::problem::{Problem, Value, is_refusal, rounded};
use crate::record::{Judged, judge};

/// Share of the seeds on which a case must fail.
pub const HOLDS_ON: f64 = 0.8;
/// Times that the way to a nominal value is halved.
const HALVINGS: usize = 3;
/// Passes over all variables, while something changes.
const PASSES: usize = 2;

/// Verdict on some values over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    pub failed: usize,
    /// Seeds that were tried. Fewer than all where the verdict was clear before.
    pub tried: usize,
    /// The first seed on which it failed, and its verdict.
    pub first: Option<(u64, Judged)>,
}

/// Drives values on several seeds.
pub trait Trial {
    fn seeds(&self) -> usize;

    /// Drives the values on the seeds, until their share of failures is clear, or on all of them. A scene that the
    /// reference does not avoid fails on none.
    fn drive(&self, values: &[Value], all: bool) -> Result<Held, Error>;

    /// Number of failures that are enough.
    fn enough(&self) -> usize {
        (HOLDS_ON * self.seeds() as f64).ceil() as usize
    }

    /// The failure holds with these values. Values that the scenario refuses hold nothing.
    fn holds(&self, values: &[Value]) -> Result<bool, Error> {
        match self.drive(values, false) {
            Ok(held) => Ok(held.failed >= self.enough()),
            // A combination on the way to the nominal values may be none of the scenario's.
            Err(error) if is_refusal(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

/// Reduces values that fail on enough seeds.
pub fn reduce(problem: &Problem, from: &[Value], trial: &dyn Trial) -> Result<Vec<Value>, Error> {
    let mut values = from.to_vec();
    for _ in 0..PASSES {
        let before = values.clone();
        for (place, variable) in problem.variables.iter().enumerate() {
            if values[place] == variable.nominal {
                continue;
            }
            let mut tried = values.clone();
            tried[place] = variable.nominal.clone();
            if trial.holds(&tried)? {
                values = tried;
            } else if let Some(nearer) = halved(problem, &values, place, trial)? {
                values = nearer;
            }
        }
        if values == before {
            break;
        }
    }
    for (place, variable) in problem.variables.iter().enumerate() {
        let Value::Number(number) = values[place] else { continue };
        if values[place] == variable.nominal || variable.domain.count().is_some() {
            continue;
        }
        for digits in 1..=4 {
            let mut tried = values.clone();
            tried[place] = variable.domain.nearest(&Value::Number(rounded(number, digits)));
            if tried[place] == values[place] {
                break;
            }
            if trial.holds(&tried)? {
                values = tried;
                break;
            }
        }
    }
    Ok(values)
}

/// Values with one variable nearer to its nominal value, as near as halving finds.
fn halved(
    problem: &Problem,
    values: &[Value],
    place: usize,
    trial: &dyn Trial,
) -> Result<Option<Vec<Value>>, Error> {
    let variable = &problem.variables[place];
    if variable.domain.is_of_words() {
        return Ok(None);
    }
    let (mut holds, mut fails) =
        (variable.domain.place(&values[place]), variable.domain.place(&variable.nominal));
    let mut found = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (holds + fails);
        let mut tried = values.to_vec();
        tried[place] = variable.domain.at(middle);
        if tried[place] == values[place] {
            break;
        }
        if trial.holds(&tried)? {
            holds = middle;
            found = Some(tried);
        } else {
            fails = middle;
        }
    }
    Ok(found)
}

/// How a command tries minimal cases.
pub struct Trials {
    /// Seed of the search.
    pub seed: u64,
    /// Seeds of a case.
    count: usize,
    group: GroupOptions,
    /// Runs at once; none: one per core.
    jobs: Option<NonZeroUsize>,
    is_quiet: bool,
}

impl Trials {
    pub fn new(arguments: &SearchArguments, run: &RunOptions) -> Result<Self, UsageError> {
        Ok(Self {
            seed: arguments.seed()?,
            count: arguments.trials.get(),
            group: run.group.clone(),
            jobs: run.jobs,
            is_quiet: run.results.json,
        })
    }

    /// Counts the runs.
    pub fn bar(&self, what: &'static str) -> ProgressBar {
        report::print::count_bar(0, self.is_quiet).with_message(what)
    }
}

/// Drives in the worker's threads.
pub struct Seeds<'a> {
    pub problem: &'a Problem,
    pub trials: &'a Trials,
    pub bar: &'a ProgressBar,
}

/// The text of a file that `timegap run` repeats. A fault with nothing to act on has no effect. A single run refuses
/// it, so the file leaves it out.
pub fn repeatable(scenario: &Scenario) -> String {
    let mut repeatable = scenario.clone();
    repeatable.faults.retain(|fault| supervise::absent(fault, scenario).is_none());
    repeatable.to_toml()
}

impl Seeds<'_> {
    fn run(&self, values: &[Value], seed: u64, going_on: &dyn Fn() -> bool) -> Result<Done, Error> {
        let scenario = self.problem.scenario(values, seed)?;
        batch::lockstep(&scenario, &self.trials.group, going_on)
    }

    pub fn repeat(&self, values: &[Value], seed: u64) -> Result<Done, Error> {
        self.run(values, seed, &|| true)
    }

    fn seed(&self, index: usize) -> u64 {
        seed_of(self.trials.seed, 7, index as u64)
    }
}

impl Trial for Seeds<'_> {
    fn seeds(&self) -> usize {
        self.trials.count
    }

    fn drive(&self, values: &[Value], all: bool) -> Result<Held, Error> {
        if self.problem.by_reference(&self.problem.scenario(values, 1)?) >= 0.0 {
            return Ok(Held { failed: 0, tried: 0, first: None });
        }
        let at_once = batch::at_once(self.trials.jobs, Mode::Lockstep);
        let (count, enough, mut done) = (self.trials.count, self.enough(), 0);
        let mut failed: Vec<(usize, Judged)> = Vec::new();
        while done < count {
            let is_clear = failed.len() >= enough || done - failed.len() > count - enough;
            if is_clear && !all {
                break;
            }
            let next = at_once.min(count - done);
            let first = done;
            let ended = Mutex::new(Vec::new());
            let work = |index: usize, going_on: &dyn Fn() -> bool| {
                self.run(values, self.seed(first + index), going_on)
            };
            let mut each = |index: usize, result: Result<Done, Error>| {
                let judged = judge(&result?.summary);
                ended.lock().expect("one thread").push((first + index, judged));
                Ok(())
            };
            batch::share(next, at_once, &ProgressBar::hidden(), &work, &mut each)?;
            self.bar.inc(next as u64);
            done += next;
            let ended = ended.into_inner().expect("one thread");
            failed.extend(ended.into_iter().filter(|(_, judged)| judged.robustness < 0.0));
        }
        failed.sort_by_key(|(index, _)| *index);
        let first = failed.first().map(|(index, judged)| (self.seed(*index), judged.clone()));
        Ok(Held { failed: failed.len(), tried: done, first })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::Command;

    /// Fails if the gap is below 30 and the set speed above 20, on nine of ten seeds. The mass does not matter.
    struct Fake;

    impl Trial for Fake {
        fn seeds(&self) -> usize {
            10
        }

        fn drive(&self, values: &[Value], _: bool) -> Result<Held, Error> {
            let of = |place: usize| values[place].number().expect("numbers");
            let fails = of(0) < 30.0 && of(1) > 20.0;
            Ok(Held { failed: if fails { 9 } else { 1 }, tried: 10, first: None })
        }
    }

    #[test]
    fn a_case_keeps_what_it_needs_and_is_round() {
        let words = "tight-brake --vary actors.0.gap_m=20..60 --vary set_speed_mps=10..40 \
                     --vary plant.length_m=4..6";
        let words: Vec<&str> = words.split(' ').collect();
        let Command { study, options } = Command::<SearchArguments>::read(&words).expect("good");
        let problem = Problem::open(&study, &options.group).expect("a problem");
        // Nominal: a gap of 27 m, 25 m/s, 4.5 m, all from the scenario.
        let from = [Value::Number(21.234), Value::Number(36.75), Value::Number(5.789)];
        let values = reduce(&problem, &from, &Fake).expect("it runs");
        assert_eq!(values, problem.nominal_values(), "the nominal values fail too");
        let mut harmless = problem.clone();
        harmless.variables[0].nominal = Value::Number(50.0);
        let values = reduce(&harmless, &from, &Fake).expect("it runs");
        assert_eq!(values[1..], harmless.nominal_values()[1..]);
        let Value::Number(gap_m) = values[0] else { panic!("a number") };
        assert!((26.0..30.0).contains(&gap_m) && gap_m.fract() == 0.0, "{gap_m}");
    }

    #[test]
    fn a_file_has_the_faults_that_act() {
        let text = |brake: bool| {
            let head = "schema_version = 1\nname = \"a\"\n[aebs]\n";
            let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"radar/detections\"\nat_s = 1\n";
            let text = format!("{head}enabled = {brake}\n{fault}");
            repeatable(&Scenario::parse("a.toml", &text).expect("a scenario"))
        };
        assert!(text(true).contains("radar/detections"));
        assert!(!text(false).contains("radar/detections"), "nothing receives it");
    }
}
