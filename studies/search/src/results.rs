//! The result of a search.

use report::html::{Tile, figure};
use report::results::{Broken, Column, Document, Object, Schema, Table, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use crate::effect::effects;
use crate::failure_row::{self, FailureRow};
use crate::fault_row::{self, FaultRow};
use crate::method::MethodName;
use crate::pictures::{self, Drives};
use crate::problem::{Problem, Value};
use crate::record::Record;

/// Scenes and faults that break a requirement.
#[derive(Debug, Serialize, JsonSchema)]
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

/// The schema of the command's JSON.
#[must_use]
pub fn schema() -> Schema {
    Schema::of::<Search>("search")
}

impl Search {
    /// The result of some runs.
    pub fn new(
        problem: &Problem,
        (method, planned): (MethodName, usize),
        records: &[(usize, Record)],
        distinct: usize,
    ) -> Self {
        let values = || records.iter().map(|(_, record)| record.value());
        let least = |values: &mut dyn Iterator<Item = f64>| values.min_by(f64::total_cmp);
        let violations = values().filter(|value| *value < 0.0).count();
        let even: Vec<&Record> =
            records.iter().map(|(_, record)| record).filter(|record| record.is_even).collect();
        let none_failed = !even.is_empty() && even.iter().all(|record| !record.is_failure());
        let effects = effects(&problem.variables, records);
        let rows = problem.variables.iter().zip(effects).map(|(variable, effect)| VariableRow {
            name: variable.name.clone(),
            values: variable.domain.to_string(),
            nominal: variable.nominal.clone(),
            effect,
        });
        Self {
            schema_version: 1,
            ok: violations == 0,
            problem: problem.name.clone(),
            controller: problem.nominal.controller.name.as_str().to_owned(),
            method: method.name(),
            requirements: problem.nominal.require.formulas.clone(),
            runs: records.len(),
            planned,
            reducing_runs: 0,
            refused: records.iter().map(|(_, record)| record.tried).sum(),
            first_violation: records
                .iter()
                .find(|(_, one)| one.is_failure())
                .map(|(run, _)| run + 1),
            violations,
            distinct,
            failures: Vec::new(),
            worst_robustness: least(&mut values()),
            nearest_miss: least(&mut values().filter(|value| *value >= 0.0)),
            // Rule of three: 1 - 0.05^(1/n) is below 3/n.
            share_below: none_failed.then(|| (3.0 / even.len() as f64).min(1.0)),
            variables: rows.collect(),
            faults: Vec::new(),
            probability: None,
            drives: Vec::new(),
        }
    }

    /// The result of `--probability`, which has no runs of a search.
    pub fn of_probability(problem: &Problem, (found, ok): (Json, bool), runs: usize) -> Self {
        let none = Self::new(problem, (MethodName::Random, runs), &[], 0);
        Self { ok, method: "probability", runs, probability: Some(found), ..none }
    }

    /// The same with its minimal cases; the files are numbered in their order.
    pub fn with_cases(
        mut self,
        cases: Vec<(FailureRow, Drives)>,
        reducing_runs: u64,
        directory: &std::path::Path,
    ) -> Self {
        self.reducing_runs = reducing_runs;
        for (place, (mut row, drives)) in cases.into_iter().enumerate() {
            row.file = format!("failure-{}.toml", place + 1);
            let path = directory.join(&row.file).to_string_lossy().into_owned();
            row.repeat = runtime::command_line(&["timegap", "run", &path, "--mode", "lockstep"]);
            self.failures.push(row);
            self.drives.push(drives);
        }
        self
    }

    /// The result of a search among faults: `values` of its runs, and its rows in their order.
    pub fn of_faults(
        problem: &Problem,
        (planned, reducing_runs, first_violation): (usize, u64, Option<usize>),
        values: Vec<f64>,
        faults: Vec<FaultRow>,
    ) -> Self {
        let runs = values.len();
        let least = |values: &mut dyn Iterator<Item = f64>| values.min_by(f64::total_cmp);
        let violations = values.iter().filter(|value| **value < 0.0).count();
        Self {
            method: MethodName::Sobol.name(),
            runs,
            planned,
            reducing_runs,
            first_violation,
            violations,
            ok: violations == 0,
            distinct: faults.iter().filter(|row| row.broken > 0).count(),
            worst_robustness: least(&mut values.iter().copied()),
            nearest_miss: least(&mut values.iter().copied().filter(|value| *value >= 0.0)),
            variables: Vec::new(),
            faults,
            ..Self::new(problem, (MethodName::Sobol, planned), &[], 0)
        }
    }

    /// The result of a search among faults for every output.
    pub fn faults_document(&self) -> Document {
        let place = &self.problem;
        let requirements = self.requirements.join(", ");
        let about = format!(
            "{place} ({}): {} faults of messages and timing, {} of {} runs, {requirements}",
            self.controller,
            self.faults.len(),
            self.runs,
            self.planned,
        );
        let sentence = match self.distinct {
            0 => format!("no fault broke a requirement in {} runs", self.runs),
            broken => {
                format!("BROKEN: {broken} of {} faults break a requirement", self.faults.len())
            }
        };
        let table = Table::new("What hurts most", fault_row::COLUMNS, &self.faults).most_rows(25);
        let document = Document::new("search", &format!("Faults in {place}"), self)
            .about(about)
            .table(table)
            .verdict(self.ok, sentence)
            .broken(self.faults.iter().filter_map(|row| {
                let command = row.repeat.clone()?;
                Some(Broken::new(format!("{} breaks {}", row.fault, row.requirement), command))
            }));
        self.faults.iter().fold(document, |document, row| match &row.file {
            Some(file) => document.file(file, row.text.clone()),
            None => document,
        })
    }

    /// The result for every output.
    pub fn document(&self, problem: &Problem, records: &[(usize, Record)]) -> Document {
        let (place, method) = (&self.problem, self.method);
        let requirements = self.requirements.join(", ");
        let about = format!(
            "{place} ({}, {method}): {}, {} of {} runs, {requirements}",
            self.controller,
            problem.count_in_words(),
            self.runs,
            self.planned,
        );
        let mut pictures = pictures::of_runs(problem, records);
        for (row, drives) in self.failures.iter().zip(&self.drives) {
            pictures.extend(pictures::of_drives(&row.file, &row.requirement, drives));
        }
        let pictures: String = pictures.iter().map(|picture| figure(picture.as_ref())).collect();
        let pictures = match pictures.as_str() {
            "" => String::new(),
            drawn => format!("<div class=\"grid\">\n{drawn}</div>\n"),
        };
        let mut document = Document::new("search", &format!("Search in {place}"), self)
            .about(about)
            .tiles(self.tiles())
            .table(Table::new("Minimal cases", failure_row::COLUMNS, &self.failures))
            .table(Table::new("Variables", VARIABLES, &self.variables).without_cases())
            .figures("Runs", pictures)
            .verdict(self.ok, self.sentence())
            .broken(self.failures.iter().map(|row| {
                Broken::new(format!("{} breaks {}", row.file, row.requirement), &row.repeat)
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
