//! Rows of the tables of minimal cases and of faults.

use std::cmp::Ordering;

use report::results::{Column, Format, column, count, judged, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value as Json, json};

use crate::minimal::Held;
use crate::problem::{Problem, Value, rounded};
use crate::record::Judged;

/// A minimal case.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FailureRow {
    /// Its file.
    pub file: String,
    #[serde(flatten)]
    pub judged: Judged,
    /// Seeds on which it fails, and seeds that were tried.
    pub holds_on: [usize; 2],
    /// Values that differ from the nominal ones, in words.
    pub differs: String,
    /// All values by the names of the variables.
    pub values: serde_json::Map<String, Json>,
    /// Failing runs of the search in its group.
    pub runs: usize,
    /// The run that it was reduced from, from 1.
    pub from_run: usize,
    /// The command that repeats it.
    pub repeat: String,
    /// Contents of the file.
    #[serde(skip)]
    pub text: String,
}

/// A fault and what it breaks.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct FaultRow {
    /// Kind and target.
    pub fault: String,
    pub runs: usize,
    /// Runs that broke a requirement.
    pub broken: usize,
    /// Smallest size that breaks a requirement.
    pub size: Option<f64>,
    /// Unit of the size; empty for a share.
    pub size_unit: &'static str,
    /// Shortest duration that breaks a requirement, s.
    pub for_s: Option<f64>,
    /// Its begin, s.
    pub at_s: Option<f64>,
    /// Seeds on which the smallest one breaks it, and seeds that were tried.
    pub holds_on: Option<[usize; 2]>,
    /// The run with the least margin.
    #[serde(flatten)]
    pub judged: Judged,
    pub file: Option<String>,
    /// The command that repeats it.
    pub repeat: Option<String>,
    /// Contents of the file.
    #[serde(skip)]
    pub text: String,
    /// Places of size and duration in their ranges, summed: a small one hurts more.
    #[serde(skip)]
    pub severity: f64,
}

pub const FAILURES: &[Column<FailureRow>] = &[
    word("file", "failure", "Scenario file that repeats it"),
    word("requirement", "requirement", "Requirement that it breaks"),
    number("margin", "margin", "", 2, "Margin of the requirement, in its unit"),
    word("unit", "unit", "Unit of the margin"),
    number("robustness", "robustness", "tolerances", 1, "Margin in tolerances of its unit")
        .less()
        .weight(3),
    judged("", "fails on", "").of(held),
    count("runs", "runs like it", "Failing runs of the search in its group").weight(2),
    count("from_run", "from run", "Run that it was reduced from").weight(3),
    column(
        "differs",
        "departs from the nominal values by",
        "",
        Format::Sentence,
        "Values that differ from the nominal ones",
    ),
];

pub const FAULTS: &[Column<FaultRow>] = &[
    word("fault", "fault", "Kind and target of the fault"),
    judged("", "breaks", "").of(breaks),
    judged("", "smallest that breaks", "").of(smallest),
    number(
        "robustness",
        "least margin",
        "tolerances",
        1,
        "Least margin of its runs, in tolerances",
    ),
    word("requirement", "of", "Requirement with this margin").weight(3),
    count("runs", "runs", "Runs with the fault").weight(2),
    word("file", "file", "Scenario file that repeats the smallest one").weight(1),
];

fn held(row: &FailureRow) -> Json {
    let [failed, tried] = row.holds_on;
    json!({"text": format!("{failed} of {tried}"), "ok": null})
}

fn breaks(row: &FaultRow) -> Json {
    let text = match (row.broken, row.holds_on) {
        (0, _) => "no".to_owned(),
        (broken, None) => format!("{broken} of {}", row.runs),
        (_, Some([failed, tried])) => format!("on {failed} of {tried} seeds"),
    };
    json!({"text": text, "ok": row.broken == 0})
}

fn smallest(row: &FaultRow) -> Json {
    let size = row.size.map(|size| match row.size_unit {
        "" => format!("{:.0} %", size * 100.0),
        unit => format!("{} {unit}", rounded(size, 3)),
    });
    let lasts = row.for_s.map(|for_s| format!("for {} s", rounded(for_s, 3)));
    let begins = row.at_s.map(|at_s| format!("from {} s", rounded(at_s, 3)));
    let words: Vec<String> = [size, lasts, begins].into_iter().flatten().collect();
    json!({"text": words.join(" "), "ok": null})
}

impl FailureRow {
    /// A case with these values, of a group of `runs` failing runs.
    pub fn new(
        problem: &Problem,
        values: &[Value],
        held: Held,
        (runs, from_run): (usize, usize),
    ) -> Self {
        let named = problem.variables.iter().zip(values);
        let differs = named.clone().filter(|(variable, value)| variable.nominal != **value);
        let differs: Vec<String> =
            differs.map(|(variable, value)| format!("{} = {value}", variable.name)).collect();
        let values = named.map(|(variable, value)| (variable.name.clone(), json!(value)));
        Self {
            file: String::new(),
            judged: held.first.map(|(_, judged)| judged).unwrap_or_default(),
            holds_on: [held.failed, held.tried],
            differs: if differs.is_empty() { "nothing".to_owned() } else { differs.join(", ") },
            values: values.collect(),
            runs,
            from_run: from_run + 1,
            repeat: String::new(),
            text: String::new(),
        }
    }
}

impl FaultRow {
    /// The order of the table: what breaks with the least, then what comes nearest to it.
    pub fn rank(&self, other: &Self) -> Ordering {
        let broken = |row: &Self| row.broken == 0;
        broken(self)
            .cmp(&broken(other))
            .then(self.severity.total_cmp(&other.severity))
            .then(self.judged.robustness.total_cmp(&other.judged.robustness))
    }
}
