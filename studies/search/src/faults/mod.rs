//! `--faults all`: what hurts most.
//!
//! ```text
//! scenario ─► every fault it can have ─ severe ones at many instants ─► which break a requirement
//!                                                                    └─► smallest size and duration of each
//! ```
//!
//! Run `r` tries fault `r mod n` at a point of the Sobol sequence over begin, duration and size. So the runs of a part
//! are spread over all faults.

mod candidates;
mod messages;
mod sort;

use std::num::NonZeroUsize;

use frame::batch::{Done, Job};
use frame::{Found, Needs, RunOptions, Study};
use group::report::Outcome;
use group::{Error, Failure, GroupOptions};
use report::results::Document;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::arguments::SearchArguments;
use crate::fault_row::FaultRow;
use crate::method::{Sobol, seed_of};
use crate::minimal::{self, Case, Trial};
use crate::problem::{Draft, Value, scenario_name};
use crate::reference::Reference;
use crate::results::Search;
use crate::trial::Seeds;
use crate::value::{Judged, judge};
use candidates::{Candidate, candidates};
use sort::{BEGIN, LASTS, SIZE};

/// Faults that are reduced at most, the worst first.
const MOST_REDUCED: usize = 20;
const MOST_FILES: usize = 5;

/// A scenario that the reference does not avoid shows nothing of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "--faults: the reference driver does not avoid the scenario itself, expected a milder one, or --reference none"
)]
pub struct NotAvoided;

impl Failure for NotAvoided {}

/// A run that was done.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FaultRecord {
    values: Vec<Value>,
    outcome: Outcome,
    judged: Judged,
}

pub struct Faults {
    name: String,
    subject: String,
    candidates: Vec<Candidate>,
    sobol: Sobol,
    budget: usize,
    seed: u64,
    seeds: usize,
    group: GroupOptions,
    jobs: Option<NonZeroUsize>,
    is_quiet: bool,
}

impl Study for Faults {
    type Arguments = SearchArguments;
    type Record = FaultRecord;
    type Seen = ();

    const NAME: &'static str = "search-faults";
    const NEEDS: Needs = Needs::Any;

    fn plan(arguments: &SearchArguments, run: &RunOptions) -> Result<Self, Error> {
        let seed = arguments.seed()?;
        let scenario = arguments.scenario.clone();
        let options = &arguments.scenario_options;
        let base = group::open(&scenario, options)?;
        let reference = Reference::named(arguments.reference.unwrap_or_default());
        if reference.is_some_and(|driver| !driver.drive(&base, false).avoids()) {
            return Err(NotAvoided.into());
        }
        // The scene is the same in all runs: the reference has been asked.
        let draft = || Draft {
            name: scenario_name(&scenario),
            scenario: scenario.clone(),
            reference: Some(None),
            ..Draft::default()
        };
        let open = |draft: Draft| draft.finish(options.clone());
        let candidates = candidates(&draft, base.duration_s.value(), &open)?;
        Ok(Self {
            name: scenario_name(&scenario),
            subject: base.to_toml(),
            sobol: Sobol::new(3, Some(seed_of(seed, 8, 0))),
            budget: arguments.budget.get(),
            seed,
            seeds: arguments.seeds.get(),
            group: run.group.clone(),
            jobs: run.jobs,
            is_quiet: run.results.json,
            candidates,
        })
    }

    fn runs(&self) -> usize {
        self.budget
    }

    fn label(&self) -> String {
        format!("search-{}-faults", self.name)
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(self.subject.clone())
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let (candidate, values) = (self.candidate(run), self.values(run));
        let number = |name: &str| {
            let value = candidate.value(name, &values);
            (name.to_owned(), value.map_or_else(String::new, |value| value.to_string()))
        };
        let fault = ("fault".to_owned(), candidate.name.clone());
        std::iter::once(fault).chain([BEGIN, LASTS, SIZE].map(number)).collect()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let seed = seed_of(self.seed, 9, run as u64);
        let scenario = self.candidate(run).problem.scenario(&self.values(run), seed)?;
        Ok(Job::lockstep(scenario))
    }

    fn record(
        &self,
        run: usize,
        _: &Job,
        result: Result<Done, Error>,
    ) -> Result<(FaultRecord, ()), Error> {
        let summary = result?.summary;
        let judged = judge(&summary);
        let outcome = summary.outcome;
        Ok((FaultRecord { values: self.values(run), outcome, judged }, ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let Found { records, shard, is_whole, directory, .. } = found;
        let records = records.all()?;
        let mut worst: Vec<Option<(usize, FaultRecord)>> = vec![None; self.candidates.len()];
        let mut tried = vec![(0, 0); self.candidates.len()];
        for (run, record) in &records {
            let place = run % self.candidates.len();
            tried[place].0 += 1;
            tried[place].1 += usize::from(record.judged.value < 0.0);
            let is_worse =
                |known: &(usize, FaultRecord)| record.judged.value < known.1.judged.value;
            if worst[place].as_ref().is_none_or(is_worse) {
                worst[place] = Some((*run, record.clone()));
            }
        }
        let first = records.iter().find(|(_, record)| record.judged.value < 0.0);
        let first = first.map(|(run, _)| run + 1);
        let mut rows = Vec::new();
        let worst = self.candidates.iter().zip(worst).zip(tried);
        for ((candidate, worst), (runs, broken)) in worst {
            let Some((_, record)) = worst else { continue };
            let named = (candidate.name.as_str(), candidate.unit);
            let row = FaultRow::new(named, &record.judged, (runs, broken));
            rows.push((candidate, record, row));
        }
        rows.sort_by(|a, b| a.1.judged.value.total_cmp(&b.1.judged.value));
        let bar = report::progress::count_bar(0, self.is_quiet);
        bar.set_message("smallest faults");
        if shard.is_none() && is_whole {
            let broken = rows.iter_mut().filter(|(_, record, _)| record.judged.value < 0.0);
            for (candidate, record, row) in broken.take(MOST_REDUCED) {
                let case = self.smallest(candidate, &record.values, &bar)?;
                let value = |name: &str| candidate.value(name, &case.values);
                (row.size, row.for_s, row.at_s) = (value(SIZE), value(LASTS), value(BEGIN));
                row.holds_on = Some([case.held.failed, case.held.tried]);
                let place = |name: &str| candidate.severity(name, &case.values);
                row.severity = place(SIZE) + place(LASTS);
                let seed = case.held.first.as_ref().map_or(self.seed, |(seed, _)| *seed);
                row.text = candidate.problem.scenario(&case.values, seed)?.to_toml();
            }
        }
        let reducing_runs = bar.position();
        bar.finish_and_clear();
        let mut rows: Vec<FaultRow> = rows.into_iter().map(|(_, _, row)| row).collect();
        rows.sort_by(FaultRow::rank);
        for (place, row) in
            rows.iter_mut().filter(|row| !row.text.is_empty()).take(MOST_FILES).enumerate()
        {
            row.file = Some(format!("failure-{}.toml", place + 1));
            let path = directory.join(format!("failure-{}.toml", place + 1));
            let path = path.to_string_lossy();
            row.repeat =
                Some(runtime::command_line(&["timegap", "run", &path, "--mode", "lockstep"]));
        }
        let problem = &self.candidates[0].problem;
        let values = records.iter().map(|(_, record)| record.judged.value);
        let search =
            Search::of_faults(problem, (self.budget, reducing_runs, first), values.collect(), rows);
        Ok(search.faults_document())
    }
}

impl Faults {
    fn candidate(&self, run: usize) -> &Candidate {
        &self.candidates[run % self.candidates.len()]
    }

    fn values(&self, run: usize) -> Vec<Value> {
        let index = run / self.candidates.len();
        self.candidate(run).severe(&self.sobol.point(index as u64))
    }

    /// The smallest size and duration that break, on enough seeds. A failure of few seeds stays as it was found.
    fn smallest(
        &self,
        candidate: &Candidate,
        values: &[Value],
        bar: &indicatif::ProgressBar,
    ) -> Result<Case, Error> {
        let trial = Seeds {
            problem: &candidate.problem,
            group: &self.group,
            jobs: self.jobs,
            seed: self.seed,
            count: self.seeds,
            bar,
        };
        if trial.holds(values)? {
            return minimal::reduce(&candidate.problem, values, &trial);
        }
        Ok(Case { values: values.to_vec(), held: trial.drive(values, true)? })
    }
}
