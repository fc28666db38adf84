//! The result of a population, for every output.

use std::collections::BTreeSet;

use report::results::{Column, Document, Format, Schema, Table, column, flag, number, word};
use report::verdicts::{LEAST, Least, least};
use scenario::Scenario;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};
use supervise::Error;

use crate::figures::{Drives, values};
use crate::limits;
use crate::population::{Drive, Finding, Planned, Population};

/// Most scenario files of drives with a finding.
const MOST_FILES: usize = 50;
/// Most drives with a finding that a terminal shows.
const MOST_SHOWN: usize = 20;

/// A figure of the counted drives beside its limit.
#[derive(Debug, Serialize)]
struct Judged {
    name: &'static str,
    /// Null if no drive has it.
    value: Option<f64>,
    limit: f64,
    /// Null without a value, which breaks no limit and meets none.
    met: Option<bool>,
    since: &'static str,
    source: &'static str,
}

const LIMITS: &[Column<Judged>] = &[
    word("name", "figure", "Path of the figure"),
    number("value", "seen", "", 4, "Its value over the counted drives"),
    number("limit", "at most", "", 4, "Its limit"),
    flag("met", "verdict", ("met", "EXCEEDED"), "The value is within its limit"),
    word("since", "since", "Day since when the limit holds").weight(2),
    word("source", "source", "Origin of the limit").weight(3),
];

/// A drive with a finding.
#[derive(Debug, Serialize)]
struct Failure {
    drive: String,
    finding: String,
    repeat: String,
    #[serde(skip)]
    breaks: bool,
}

/// Columns of the drives with a finding.
const FAILURES: &[Column<Failure>] = &[
    word("drive", "drive", "Kind, number and law"),
    word("finding", "finding", "What it did"),
    column("repeat", "", "", Format::Command, "Command that repeats the drive"),
];

/// Drives of a population. Its figures and groups stand beside these keys.
#[derive(Serialize, JsonSchema)]
struct Head<'a> {
    schema_version: u32,
    /// No drive broke what no drive may break, and the limits that decide hold.
    ok: bool,
    /// Numbers of scenes that were driven.
    scenes: usize,
    drives: usize,
    /// Laws that drove.
    laws: &'a [&'a str],
}

/// Contents of a population's JSON.
pub fn schema<P: Population>() -> Schema {
    let figures = P::figures();
    let total: Vec<Column<Value>> = figures.iter().map(|figure| figure.column.clone()).collect();
    let schema = Schema::of::<Head<'_>>(P::NAME).fields(&total);
    let groups = P::groups();
    let rows = |schema: Schema, group: &crate::figures::Group<P::Facts>| {
        schema.rows(group.name, group.title, &group.columns())
    };
    groups
        .iter()
        .fold(schema, rows)
        .rows("limits", "Figures of the counted drives with a limit", LIMITS)
        .rows("failures", "Drives with a finding", FAILURES)
        .rows("margins", "Least margins of the requirements of the command", LEAST)
}

/// The figures of the counted drives beside their limits.
fn judged<P: Population>(total: &Map<String, Value>) -> Vec<Judged> {
    let total = Value::Object(total.clone());
    let judge = |limit: &'static limits::Limit| {
        let limits::Limit { figure: name, most: limit, since, source, .. } = *limit;
        let value = report::results::at(&total, name).and_then(Value::as_f64);
        let met = value.map(|value| value <= limit);
        Judged { name, value, limit, met, since, source }
    };
    limits::of(P::NAME).map(judge).collect()
}

/// `repeat` is the command of a drive, and `scenario` its file.
pub fn document<P: Population>(
    drives: &[Drive<P::Facts>],
    repeat: &dyn Fn(&Planned) -> String,
    scenario: &dyn Fn(&Planned) -> Result<Scenario, Error>,
) -> Document {
    let counted = drives.iter().filter(|drive| P::counts(drive));
    let counted = Drives { labels: Vec::new(), all: counted.collect() };
    let mut total = Map::new();
    values(&P::figures(), &counted, &mut total);
    let limits = judged::<P>(&total);
    let judged = || drives.iter().filter(|drive| P::is_judged(drive));
    let found: Vec<(&Drive<P::Facts>, Failure)> = judged()
        .filter_map(|drive| {
            let (breaks, finding) = match P::finding(drive)? {
                Finding::Breaks(words) => (true, words),
                Finding::Counts(words) => (false, words),
            };
            let (name, repeat) = (drive.planned.name(), repeat(&drive.planned));
            Some((drive, Failure { drive: name, finding, repeat, breaks }))
        })
        .collect();
    let margins =
        least(judged().map(|drive| (drive.planned.name(), drive.requirements.as_slice())));
    let (files, failures): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let groups: Vec<_> = P::groups().into_iter().map(|group| (group.rows(drives), group)).collect();
    let ok = (!P::LIMITS_DECIDE || limits.iter().all(|limit| limit.met != Some(false)))
        && failures.iter().all(|failure| !failure.breaks)
        && margins.iter().all(|least: &Least| least.verdict.met);
    let mut laws: Vec<&str> = Vec::new();
    let scenes: BTreeSet<usize> = drives.iter().map(|drive| drive.planned.number).collect();
    for Drive { planned, .. } in drives {
        if !planned.law.is_empty() && !laws.contains(&planned.law.as_str()) {
            laws.push(&planned.law);
        }
    }
    let mut whole = Map::new();
    let (scenes, count) = (scenes.len(), drives.len());
    let head = json!(Head { schema_version: 1, ok, scenes, drives: count, laws: &laws });
    whole.extend(head.as_object().cloned().unwrap_or_default());
    whole.extend(total);
    whole.extend(groups.iter().map(|(rows, group)| (group.name.to_owned(), json!(rows))));
    let rest = json!({
        "limits": limits, "failures": failures, "margins": margins
    });
    whole.extend(rest.as_object().cloned().unwrap_or_default());
    let breaking = failures.iter().filter(|failure| failure.breaks).count();
    let missed: Vec<&str> =
        limits.iter().filter(|limit| limit.met == Some(false)).map(|limit| limit.name).collect();
    let met = limits.iter().filter(|limit| limit.met == Some(true)).count();
    let verdict = format!(
        "{breaking} of {} drives broke what no drive may break; {}",
        judged().count(),
        match missed.as_slice() {
            [] if met == limits.len() => format!("all {met} limits met"),
            [] => format!("{met} of {} limits met, the others have no drive", limits.len()),
            missed => format!(
                "{} of {} limits EXCEEDED: {}",
                missed.len(),
                limits.len(),
                missed.join(", ")
            ),
        }
    );
    let mut document = Document::new(P::NAME, P::TITLE, &whole)
        .about(format!("{} scenes, {} drives by {}, lockstep", scenes, count, laws.join(", ")))
        .verdict(ok, verdict);
    for (rows, group) in &groups {
        let table = Table::new(group.title, &group.columns(), rows).without_cases();
        let blocks = group.labels.first().filter(|_| group.labels.len() > 1);
        document = document.table(match blocks {
            Some(label) => table.blocks(&label.head.name),
            None => table,
        });
    }
    document = document
        .table(Table::new("Limits", LIMITS, &limits))
        .table(
            Table::new("Drives with a finding", FAILURES, &failures)
                .most_rows(MOST_SHOWN)
                .without_cases(),
        )
        .table(Table::new("Requirements of the command", LEAST, &margins));
    for drive in files.into_iter().take(MOST_FILES) {
        let name = drive.planned.name().replace([' ', ',', '+'], "-");
        if let Ok(scenario) = scenario(&drive.planned) {
            document = document.file(&format!("{name}.toml"), scenario.to_toml());
        }
    }
    document
}
