//! The runs to blame for broken requirements.

use super::plan::Plan;
use super::record::Record;
use super::sums::Limit;
use runtime::Mode;
use schemars::JsonSchema;
use serde::Serialize;
use supervise::UsageError;

/// A run to blame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Failure {
    /// Its number.
    pub run: usize,
    /// Its scenario.
    pub scenario: String,
    /// Its faults in words.
    pub faults: Vec<String>,
    /// The broken figures with their values, then the reasons of the run itself.
    pub why: String,
    /// The command that repeats it.
    pub repeat: String,
}

/// Runs to blame that have scenario and fault in common. A run with several faults counts for each.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Broken {
    /// The scenario.
    pub scenario: String,
    /// The fault.
    pub fault: String,
    /// Number of runs.
    pub runs: u64,
}

/// Collects the runs to blame.
pub struct Blame<'a> {
    plan: &'a Plan,
    mode: Mode,
    limits: Vec<Limit>,
    failures: Vec<Failure>,
    broken: Vec<Broken>,
}

impl<'a> Blame<'a> {
    /// Looks for runs that break one of `limits`.
    pub fn new(plan: &'a Plan, mode: Mode, limits: Vec<Limit>) -> Self {
        Self { plan, mode, limits, failures: Vec::new(), broken: Vec::new() }
    }

    /// Adds a run if it is to blame.
    pub fn add(&mut self, record: &Record) -> Result<(), UsageError> {
        let blamed = self.limits.iter().filter_map(|limit| {
            let value = limit.blames(record)?;
            Some(format!("{} {value}", limit.figure.name))
        });
        let mut reasons: Vec<String> = blamed.collect();
        if reasons.is_empty() {
            return Ok(());
        }
        let broken = record.requirements.iter().filter(|verdict| !verdict.met);
        reasons.extend(broken.map(|verdict| {
            format!("{}: {}", verdict.requirement, report::print::requirement(verdict))
        }));
        let measured = &record.measured;
        reasons.extend(record.aborted_because.clone());
        reasons.extend(measured.leaks.iter().chain(&measured.degraded).cloned());
        let planned = self.plan.get(record.run)?;
        let mut faults = planned.faults();
        // A case without a fault is known by its name.
        if faults.is_empty() && planned.fault.starts_with("case ") {
            faults.push(planned.fault.clone());
        }
        faults.iter().for_each(|fault| self.count(&record.scenario, fault));
        self.failures.push(Failure {
            run: record.run,
            scenario: record.scenario.clone(),
            why: reasons.join("; "),
            repeat: planned.repeat(self.mode.name()),
            faults,
        });
        Ok(())
    }

    fn count(&mut self, scenario: &str, fault: &str) {
        let known = |broken: &&mut Broken| broken.scenario == scenario && broken.fault == fault;
        if let Some(broken) = self.broken.iter_mut().find(known) {
            broken.runs += 1;
            return;
        }
        let (scenario, fault) = (scenario.to_owned(), fault.to_owned());
        self.broken.push(Broken { scenario, fault, runs: 1 });
    }

    /// The runs in the order of their numbers, and the same by scenario and fault, the most frequent pairs first.
    pub fn found(mut self) -> (Vec<Failure>, Vec<Broken>) {
        self.broken.sort_by_key(|broken| std::cmp::Reverse(broken.runs));
        (self.failures, self.broken)
    }
}
