//! The result of a search.

use std::path::Path;

use report::html::{Tile, figure, grid};
use report::print::counted;
use report::results::{Broken, Column, Document, Object, Schema, Table, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use crate::distinct::effects;
use crate::method::MethodName;
use crate::pictures::{self, Drives};
use crate::problem::{Problem, Value};
use crate::record::Record;
use crate::rows::{FAILURES, FAULTS, FailureRow, FaultRow};

/// Scenes and faults that break a requirement.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct Search {
    schema_version: u32,
    /// No run broke a requirement in a scene that the reference avoids.
    ok: bool,
    /// Name of the problem.
    problem: String,
    /// Control law.
    controller: String,
    /// Choice of the points: gp, sobol or random; probability with `--probability`.
    method: &'static str,
    requirements: Vec<String>,
    /// Runs of the search.
    runs: usize,
    /// Runs that were planned.
    planned: usize,
    /// Runs for minimal cases.
    reducing_runs: u64,
    /// Points that the reference did not avoid, and that were not driven.
    refused: usize,
    /// Number of the first failing run, from 1.
    first_violation: Option<usize>,
    /// Failing runs.
    violations: usize,
    /// Groups of failing runs that are not neighbours.
    distinct: usize,
    /// Minimal cases, the worst first.
    failures: Vec<FailureRow>,
    /// Least value, tolerances.
    worst_robustness: Option<f64>,
    /// Least value of a run that is not a failure, tolerances.
    nearest_miss: Option<f64>,
    /// Upper end of the 95 % interval of the share of failures, by even points; none where they failed.
    share_below: Option<f64>,
    variables: Vec<VariableRow>,
    /// Faults by what they break, with `--faults`.
    faults: Vec<FaultRow>,
    /// Probability of a failure, with `--probability`.
    #[schemars(with = "Option<Object>")]
    probability: Option<Json>,
    #[serde(skip)]
    drives: Vec<Drives>,
}

/// A variable.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct VariableRow {
    name: String,
    values: String,
    /// Its harmless value.
    #[schemars(with = "Json")]
    nominal: Value,
    /// Share of the values' variance that it explains alone.
    effect: Option<f64>,
}

const VARIABLES: &[Column<VariableRow>] = &[
    word("name", "variable", "Name of the variable"),
    word("values", "values", "Its values"),
    report::results::value("nominal", "nominal", "Its harmless value"),
    number("effect", "effect", "", 2, "Share of the variance of the values that it explains alone"),
];

/// Name of a failure's file, and the command that repeats it.
pub fn repeated(directory: &Path, place: usize) -> (String, String) {
    let file = format!("failure-{}.toml", place + 1);
    let path = directory.join(&file).to_string_lossy().into_owned();
    (file, runtime::command_line(&["timegap", "run", &path, "--mode", "lockstep"]))
}

/// The schema of the command's JSON.
pub fn schema() -> Schema {
    Schema::of::<Search>("search")
}

impl Search {
    /// A result before its runs.
    fn begun(problem: &Problem, method: &'static str, planned: usize) -> Self {
        Self {
            schema_version: 1,
            ok: true,
            problem: problem.name.clone(),
            controller: problem.nominal.controller.name.as_str().to_owned(),
            method,
            requirements: problem.nominal.require.formulas.clone(),
            planned,
            ..Self::default()
        }
    }

    fn count(&mut self, runs: &[(usize, f64)]) {
        let values = || runs.iter().map(|(_, value)| *value);
        self.runs = runs.len();
        self.violations = values().filter(|value| *value < 0.0).count();
        self.ok = self.violations == 0;
        let first = runs.iter().find(|(_, value)| *value < 0.0);
        self.first_violation = first.map(|(run, _)| run + 1);
        self.worst_robustness = values().min_by(f64::total_cmp);
        self.nearest_miss = values().filter(|value| *value >= 0.0).min_by(f64::total_cmp);
    }

    /// The result of some runs.
    pub fn new(
        problem: &Problem,
        (method, planned): (MethodName, usize),
        records: &[(usize, Record)],
        distinct: usize,
    ) -> Self {
        let mut search = Self::begun(problem, method.name(), planned);
        let values = records.iter().map(|(run, record)| (*run, record.value()));
        search.count(&values.collect::<Vec<_>>());
        let even = || records.iter().filter(|(_, record)| record.driven.is_even);
        let none_failed = even().all(|(_, record)| !record.is_failure());
        // Rule of three: 1 - 0.05^(1/n) is below 3/n.
        let share_below = (3.0 / even().count() as f64).min(1.0);
        let effects = effects(&problem.variables, records);
        let rows = problem.variables.iter().zip(effects).map(|(variable, effect)| VariableRow {
            name: variable.name.clone(),
            values: variable.domain.to_string(),
            nominal: variable.nominal.clone(),
            effect,
        });
        Self {
            distinct,
            refused: records.iter().map(|(_, record)| record.driven.tried).sum(),
            share_below: (none_failed && even().count() > 0).then_some(share_below),
            variables: rows.collect(),
            ..search
        }
    }

    /// The result of `--probability`, which has no runs of a search.
    pub fn of_probability(problem: &Problem, (found, ok): (Json, bool), runs: usize) -> Self {
        let search = Self::begun(problem, "probability", runs);
        let variables = Self::new(problem, (MethodName::Random, runs), &[], 0).variables;
        Self { ok, runs, variables, probability: Some(found), ..search }
    }

    /// The same with its minimal cases; the files are numbered in their order.
    pub fn with_cases(
        mut self,
        cases: Vec<(FailureRow, Drives)>,
        reducing_runs: u64,
        directory: &Path,
    ) -> Self {
        self.reducing_runs = reducing_runs;
        for (place, (mut row, drives)) in cases.into_iter().enumerate() {
            (row.file, row.repeat) = repeated(directory, place);
            self.failures.push(row);
            self.drives.push(drives);
        }
        self
    }

    /// The result of a search among faults: its rows in their order.
    pub fn of_faults(
        problem: &Problem,
        (planned, reducing_runs): (usize, u64),
        runs: &[(usize, f64)],
        faults: Vec<FaultRow>,
    ) -> Self {
        let mut search = Self::begun(problem, MethodName::Sobol.name(), planned);
        search.count(runs);
        let distinct = faults.iter().filter(|row| row.broken > 0).count();
        Self { reducing_runs, distinct, faults, ..search }
    }

    fn about(&self, searched: &str) -> String {
        let Self { problem, controller, runs, planned, .. } = self;
        let requirements = self.requirements.join(", ");
        format!("{problem} ({controller}): {searched}, {runs} of {planned} runs, {requirements}")
    }

    /// The result of a search among faults for every output.
    pub fn faults_document(&self) -> Document {
        let place = &self.problem;
        let about = self.about(&format!("{} faults of messages and timing", self.faults.len()));
        let sentence = match self.distinct {
            0 => format!("no fault broke a requirement in {} runs", self.runs),
            broken => {
                format!("BROKEN: {broken} of {} faults break a requirement", self.faults.len())
            }
        };
        let table = Table::new("What hurts most", FAULTS, &self.faults).most_rows(25);
        let document = Document::new("search", &format!("Faults in {place}"), self)
            .about(about)
            .table(table)
            .verdict(self.ok, sentence)
            .broken(self.faults.iter().filter_map(|row| {
                let command = row.repeat.clone()?;
                Some(Broken::new(
                    format!("{} breaks {}", row.fault, row.judged.requirement),
                    command,
                ))
            }));
        self.faults.iter().fold(document, |document, row| match &row.file {
            Some(file) => document.file(file, row.text.clone()),
            None => document,
        })
    }

    /// The result for every output.
    pub fn document(&self, problem: &Problem, records: &[(usize, Record)]) -> Document {
        let place = &self.problem;
        let about = self.about(&format!(
            "{}, {}",
            self.method,
            counted(problem.dimensions() as u64, "variable")
        ));
        let mut pictures = pictures::of_runs(problem, records);
        for (row, drives) in self.failures.iter().zip(&self.drives) {
            pictures.extend(pictures::of_drives(&row.file, &row.judged.requirement, drives));
        }
        let pictures: String = pictures.into_iter().map(figure).collect();
        let mut document = Document::new("search", &format!("Search in {place}"), self)
            .about(about)
            .tiles(self.tiles())
            .table(Table::new("Minimal cases", FAILURES, &self.failures))
            .table(Table::new("Variables", VARIABLES, &self.variables).without_cases())
            .figures("Runs", grid(&pictures))
            .verdict(self.ok, self.sentence())
            .broken(self.failures.iter().map(|row| {
                Broken::new(format!("{} breaks {}", row.file, row.judged.requirement), &row.repeat)
            }));
        for row in &self.failures {
            document = document.file(&row.file, row.text.clone());
        }
        document
    }

    fn tiles(&self) -> Vec<Tile> {
        let tile = |label, value: String, note: String| Tile { label, value, note };
        let run = |run: Option<usize>| run.map_or_else(|| "none".to_owned(), |run| run.to_string());
        let tolerances = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"))
        };
        vec![
            tile(
                "Runs",
                self.runs.to_string(),
                format!("and {} for minimal cases", self.reducing_runs),
            ),
            tile("First violation at run", run(self.first_violation), String::new()),
            tile("Violations", self.violations.to_string(), format!("{} distinct", self.distinct)),
            tile("Least value", tolerances(self.worst_robustness), "tolerances".to_owned()),
            tile("Nearest miss", tolerances(self.nearest_miss), "tolerances".to_owned()),
            tile("Not driven", self.refused.to_string(), "the reference fails too".to_owned()),
        ]
    }

    fn sentence(&self) -> String {
        let missing = match self.planned - self.runs {
            0 => String::new(),
            missing => format!("INCOMPLETE: {missing} runs are missing; "),
        };
        let miss = self.nearest_miss.map(|value| format!("; nearest miss {value:.1} tolerances"));
        let miss = miss.unwrap_or_default();
        match self.first_violation {
            Some(first) => format!(
                "{missing}BROKEN: first violation at run {first}, {} violations, {} distinct{miss}",
                self.violations, self.distinct
            ),
            None => {
                let share = self.share_below.map(|share| {
                    format!(
                        "; failures fill less than {:.2} % of the box (95 %, by its even points)",
                        share * 100.0
                    )
                });
                format!(
                    "{missing}no violation in {} runs{miss}{}",
                    self.runs,
                    share.unwrap_or_default()
                )
            }
        }
    }
}
