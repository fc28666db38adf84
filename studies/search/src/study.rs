//! The command as a study of the frame.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::{Condvar, Mutex};
use std::time::Duration;

use frame::batch::{self, Done, Job};
use frame::parts::ShardChoice;
use frame::{Command, Crew, Entry, Found, Needs, Recorded, RunOptions, Study};
use indicatif::ProgressBar;
use report::results::{Column, Document, fact, number, word};
use serde_json::json;
use supervise::{Error, GroupOptions, UsageError};

use crate::faults::Faults;
use crate::method::{Chooser, MethodName, Proposal, independent, seed_of};
use crate::minimal::{self, Held, Seeds, Trial, Trials, repeatable};
use crate::pictures::Drives;
use crate::probability::Probability;
use crate::problem::{Problem, Value};
use crate::record::{Judged, Record, judge};
use crate::results::Search;
use crate::rows::FailureRow;
use crate::{SearchArguments, distinct, reference};

/// Longest wait for a result before an interrupt is looked for.
const LOOK: Duration = Duration::from_millis(50);

pub fn run(command: &Command<SearchArguments>) -> Result<ExitCode, Error> {
    match &command.study {
        arguments if arguments.probability => frame::run::<Probability>(command),
        arguments if arguments.faults.is_some() => frame::run::<Faults>(command),
        _ => frame::run::<Runs>(command),
    }
}

/// The studies of the command, for `merge` and `resume`.
pub const STUDIES: [Entry; 3] =
    [Entry::of::<Runs>(), Entry::of::<Faults>(), Entry::of::<Probability>()];

struct Runs {
    problem: Problem,
    method: MethodName,
    budget: usize,
    /// Number of minimal cases.
    cases: usize,
    trials: Trials,
    chooser: Mutex<Chooser>,
    /// A run ended: others may have waited for it.
    ended: Condvar,
    under_way: Mutex<BTreeMap<usize, Proposal>>,
}

impl Runs {
    /// The point of a run, when the results that its choice needs are there.
    fn proposal(&self, run: usize, going_on: &dyn Fn() -> bool) -> Result<Proposal, Error> {
        let admit = |point: &[f64]| self.problem.admit(point);
        if self.method == MethodName::Random {
            return independent(self.problem.dimensions(), self.trials.seed, run, &admit);
        }
        let mut chooser = self.chooser.lock().expect("no worker panics here");
        while !chooser.is_ready(run) {
            if !going_on() {
                return Err(Error::Interrupted);
            }
            (chooser, _) = self.ended.wait_timeout(chooser, LOOK).expect("no worker panics here");
        }
        chooser.propose(run, &admit)
    }

    fn tell(&self, run: usize, record: &Record) {
        let mut chooser = self.chooser.lock().expect("no worker panics here");
        let (driven, value) = record.told();
        chooser.tell(run, &driven, value);
        self.ended.notify_all();
    }
}

impl Study for Runs {
    type Arguments = SearchArguments;
    type Record = Record;
    type Seen = ();

    const OWN_COLUMNS: &[Column<Record>] = &[
        word("judged.requirement", "", "Requirement that decides the run"),
        number("judged.margin", "", "", 4, "Its margin"),
        word("judged.unit", "", "Unit of the margin"),
        number("value", "", "tolerances", 4, "The margin in tolerances")
            .of(|record| json!(record.value())),
        fact("is_even", "", "Drawn evenly from the admissible points"),
    ];
    const NAME: &'static str = "search";
    const NEEDS: Needs = Needs::Any;

    fn plan(arguments: &SearchArguments, options: &RunOptions) -> Result<Self, Error> {
        let (method, replicas) = (arguments.method, arguments.replicas.get());
        if replicas > 1 && method != MethodName::Gp {
            let why = format_args!("runs of `{}` do not depend on each other", method.name());
            return Err(UsageError::at("--replicas", why, "`gp`").into());
        }
        if let Some(shard) = options.shard.map(ShardChoice::resolve).transpose()?
            && method == MethodName::Gp
            && !replicas.is_multiple_of(shard.count as usize)
        {
            let place = format_args!("--shard {}/{}", shard.index, shard.count);
            let expected = format_args!("--replicas {} or a multiple", shard.count);
            return Err(UsageError::at(place, "a part holds whole replicas", expected).into());
        }
        let trials = Trials::new(arguments, options)?;
        let problem = Problem::open(arguments, &options.group)?;
        let chooser = Chooser::new(method, &problem.kinds(), trials.seed, replicas);
        Ok(Self {
            method,
            budget: arguments.budget.get(),
            cases: arguments.cases.into(),
            trials,
            chooser: Mutex::new(chooser),
            ended: Condvar::new(),
            under_way: Mutex::default(),
            problem,
        })
    }

    fn runs(&self) -> usize {
        self.budget
    }

    fn label(&self) -> String {
        format!("search-{}", self.problem.name)
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(self.problem.subject())
    }

    fn recall(&self, run: usize, record: &Record) {
        self.tell(run, record);
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let under_way = self.under_way.lock().expect("no worker panics here");
        let values = under_way.get(&run).map(|proposal| self.problem.values(&proposal.point));
        self.problem.named(&values.unwrap_or_else(|| self.problem.middle()))
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        let proposal = self.proposal(run, crew.going_on())?;
        let values = self.problem.values(&proposal.point);
        let scenario = self.problem.scenario(&values, seed_of(self.trials.seed, 6, run as u64))?;
        self.under_way.lock().expect("no worker panics here").insert(run, proposal);
        crew.drive_and_record(self, run, &Job::lockstep(scenario))
    }

    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        let summary = result?.summary;
        let proposal = self.under_way.lock().expect("no worker panics here").remove(&run);
        let driven = proposal.expect("the run was proposed");
        let record = Record {
            values: self.problem.values(&driven.point),
            driven,
            seed: job.scenario.seed.value(),
            outcome: summary.outcome,
            judged: judge(&summary),
        };
        self.tell(run, &record);
        Ok((record, ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let Found { records, shard, is_whole, directory, .. } = found;
        let records = records.all()?;
        let groups = distinct::groups(&self.problem.variables, &records);
        let plan = (self.method, self.budget);
        let search = Search::new(&self.problem, plan, &records, groups.len());
        // A part and an interrupted search have no last word on what is distinct.
        if shard.is_some() || !is_whole {
            return Ok(search.document(&self.problem, &records));
        }
        let bar = self.trials.bar("minimal cases");
        let cases = self.reduce(&groups, &records, &bar);
        let reducing_runs = bar.position();
        bar.finish_and_clear();
        let search = search.with_cases(cases?, reducing_runs, &directory);
        Ok(search.document(&self.problem, &records))
    }
}

/// Failures of a group that are tried until one holds on enough seeds.
const MOST_STARTS: usize = 4;
/// Groups that are tried, for each desired case.
const GROUPS_PER_CASE: usize = 3;

impl Runs {
    /// Minimal cases of the worst groups: those that hold on enough seeds, then others.
    fn reduce(
        &self,
        groups: &[Vec<usize>],
        records: &[(usize, Record)],
        bar: &ProgressBar,
    ) -> Result<Vec<(FailureRow, Drives)>, Error> {
        let trial = Seeds { problem: &self.problem, trials: &self.trials, bar };
        let mut sure: Vec<(FailureRow, Drives)> = Vec::new();
        let mut unsure = Vec::new();
        for group in groups.iter().take(GROUPS_PER_CASE * self.cases) {
            if sure.len() == self.cases {
                break;
            }
            match self.case(group, records, &trial)? {
                // Two groups may have one cause.
                Some((row, _)) if sure.iter().any(|(known, _)| known.values == row.values) => {}
                Some(case) => sure.push(case),
                None => unsure.push(group),
            }
        }
        // A failure of few seeds stays as it was found.
        for group in unsure.into_iter().take(self.cases - sure.len()) {
            let (run, record) = &records[group[0]];
            // Its own seed fails in any case.
            let own = (record.seed, record.judged.clone());
            sure.push(self.row(record.values.clone(), Some(own), (group.len(), *run), &trial)?);
        }
        Ok(sure)
    }

    /// The minimal case of a group; none if its worst failures hold on too few seeds.
    fn case(
        &self,
        group: &[usize],
        records: &[(usize, Record)],
        trial: &Seeds<'_>,
    ) -> Result<Option<(FailureRow, Drives)>, Error> {
        for member in group.iter().take(MOST_STARTS) {
            let (run, record) = &records[*member];
            if trial.holds(&record.values)? {
                let values = minimal::reduce(&self.problem, &record.values, trial)?;
                return Ok(Some(self.row(values, None, (group.len(), *run), trial)?));
            }
        }
        Ok(None)
    }

    /// The row of a case, with its file and its drives. `own` is a failure that stands in where no seed fails.
    fn row(
        &self,
        values: Vec<Value>,
        own: Option<(u64, Judged)>,
        from: (usize, usize),
        trial: &Seeds<'_>,
    ) -> Result<(FailureRow, Drives), Error> {
        let held = trial.drive(&values, true)?;
        let held = Held { first: held.first.or(own), ..held };
        let seed = held.first.as_ref().map_or(self.trials.seed, |(seed, _)| *seed);
        let scenario = self.problem.scenario(&values, seed)?;
        let mut row = FailureRow::new(&self.problem, &values, held, from);
        row.text = repeatable(&scenario);
        let done = trial.repeat(&values, seed)?;
        let mut verdicts = done.summary.requirements.iter();
        let decided = verdicts.find(|verdict| verdict.requirement == row.judged.requirement);
        let decided_s = decided.map(|verdict| verdict.at_s);
        let reference = self.problem.reference;
        let reference = reference.map(|driver| reference::drive(driver, &scenario, true).samples);
        Ok((row, Drives::new(&done.drive.steps, reference.unwrap_or_default(), decided_s)))
    }
}

/// Number of the first failing run of a search in the caller's thread, from 1; none within the budget.
pub fn first_violation(
    problem: &Problem,
    (method, seed): (MethodName, u64),
    budget: usize,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Option<usize>, Error> {
    let mut chooser = Chooser::new(method, &problem.kinds(), seed, 1);
    for run in 0..budget {
        let driven = chooser.propose(run, &|point| problem.admit(point))?;
        let values = problem.values(&driven.point);
        let scenario = problem.scenario(&values, seed_of(seed, 6, run as u64))?;
        let value = judge(&batch::lockstep(&scenario, group, going_on)?.summary).robustness;
        if value < 0.0 {
            return Ok(Some(run + 1));
        }
        chooser.tell(run, &driven, value);
    }
    Ok(None)
}
