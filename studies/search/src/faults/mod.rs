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

use frame::batch::{Done, Job};
use frame::{Found, Needs, Recorded, RunOptions, Study};
use report::results::Document;
use serde::{Deserialize, Serialize};
use supervise::report::Outcome;
use supervise::{Error, UsageError};

use crate::SearchArguments;
use crate::method::{Sobol, seed_of};
use crate::minimal::{self, Held, Seeds, Trial, Trials};
use crate::problem::{Problem, Value};
use crate::record::{Judged, judge};
use crate::reference;
use crate::results::{Search, repeated};
use crate::rows::FaultRow;
use candidates::{BEGIN, Candidate, LASTS, SIZE, candidates};

/// Faults that are reduced at most, the worst first.
const MOST_REDUCED: usize = 20;
const MOST_FILES: usize = 5;

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
    trials: Trials,
}

impl Study for Faults {
    type Arguments = SearchArguments;
    type Record = FaultRecord;
    type Seen = ();

    const NAME: &'static str = "search-faults";
    const NEEDS: Needs = Needs::Any;

    fn plan(arguments: &SearchArguments, run: &RunOptions) -> Result<Self, Error> {
        let trials = Trials::new(arguments, run)?;
        let mut base = Problem::new(&arguments.scenario, &arguments.scenario_options)?;
        let laws = &arguments.scenario_options.laws;
        laws.expect_all_in(&[base.nominal.controller.name.as_str()])?;
        let reference = arguments.reference.unwrap_or_default().driver();
        if reference.is_some_and(|driver| !reference::drive(driver, &base.nominal, false).avoids())
        {
            let why = "the reference driver does not avoid the scenario itself";
            return Err(UsageError::at("--faults", why, "a milder one, or --reference none").into());
        }
        // The scene is the same in all runs: the reference has been asked.
        base.reference = None;
        let candidates = candidates(&base)?;
        Ok(Self {
            name: base.name,
            subject: base.nominal.to_toml(),
            sobol: Sobol::new(3, Some(seed_of(trials.seed, 8, 0))),
            budget: arguments.budget.get(),
            trials,
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
        let seed = seed_of(self.trials.seed, 9, run as u64);
        let scenario = self.candidate(run).problem.scenario(&self.values(run), seed)?;
        Ok(Job::lockstep(scenario))
    }

    fn record(&self, run: usize, _: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        let summary = result?.summary;
        let judged = judge(&summary);
        let outcome = summary.outcome;
        Ok((FaultRecord { values: self.values(run), outcome, judged }, ()))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let Found { records, shard, is_whole, directory, .. } = found;
        let records = records.all()?;
        let mut rows: Vec<(&Candidate, &FaultRecord, FaultRow)> = Vec::new();
        for (place, candidate) in self.candidates.iter().enumerate() {
            let tried = records.iter().filter(|(run, _)| run % self.candidates.len() == place);
            let tried: Vec<&FaultRecord> = tried.map(|(_, record)| record).collect();
            let value = |record: &&&FaultRecord| record.judged.robustness;
            let worst = tried.iter().min_by(|a, b| value(a).total_cmp(&value(b)));
            let Some(&worst) = worst else { continue };
            let row = FaultRow {
                fault: candidate.name.clone(),
                size_unit: candidate.unit,
                runs: tried.len(),
                broken: tried.iter().filter(|record| value(record) < 0.0).count(),
                judged: worst.judged.clone(),
                // Behind each fault that was reduced.
                severity: 2.0,
                ..FaultRow::default()
            };
            rows.push((candidate, worst, row));
        }
        rows.sort_by(|a, b| a.1.judged.robustness.total_cmp(&b.1.judged.robustness));
        let bar = self.trials.bar("smallest faults");
        if shard.is_none() && is_whole {
            let broken = rows.iter_mut().filter(|(_, record, _)| record.judged.robustness < 0.0);
            for (candidate, record, row) in broken.take(MOST_REDUCED) {
                let (values, held) = self.smallest(candidate, &record.values, &bar)?;
                let value = |name: &str| candidate.value(name, &values);
                (row.size, row.for_s, row.at_s) = (value(SIZE), value(LASTS), value(BEGIN));
                row.holds_on = Some([held.failed, held.tried]);
                row.severity =
                    [SIZE, LASTS].map(|name| candidate.severity(name, &values)).iter().sum();
                let seed = held.first.map_or(self.trials.seed, |(seed, _)| seed);
                row.text = candidate.problem.scenario(&values, seed)?.to_toml();
            }
        }
        let reducing_runs = bar.position();
        bar.finish_and_clear();
        let mut rows: Vec<FaultRow> = rows.into_iter().map(|(_, _, row)| row).collect();
        rows.sort_by(FaultRow::rank);
        let with_file = rows.iter_mut().filter(|row| !row.text.is_empty()).take(MOST_FILES);
        for (place, row) in with_file.enumerate() {
            let (file, repeat) = repeated(&directory, place);
            (row.file, row.repeat) = (Some(file), Some(repeat));
        }
        let values = records.iter().map(|(run, record)| (*run, record.judged.robustness));
        let (problem, values) = (&self.candidates[0].problem, values.collect::<Vec<_>>());
        let search = Search::of_faults(problem, (self.budget, reducing_runs), &values, rows);
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
    ) -> Result<(Vec<Value>, Held), Error> {
        let trial = Seeds { problem: &candidate.problem, trials: &self.trials, bar };
        let values = match trial.holds(values)? {
            true => minimal::reduce(&candidate.problem, values, &trial)?,
            false => values.to_vec(),
        };
        let held = trial.drive(&values, true)?;
        Ok((values, held))
    }
}
