//! A row of the table "what hurts most".

use std::cmp::Ordering;

use report::results::{Column, count, judged, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value as Json, json};

use crate::problem::rounded;
use crate::value::Judged;

/// A fault and what it breaks.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FaultRow {
    /// Kind and target.
    pub fault: String,
    /// Runs with it.
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
    /// The requirement with the least margin.
    pub requirement: String,
    /// Least margin of the runs, in its unit.
    pub margin: Option<f64>,
    /// The unit.
    pub unit: String,
    /// The same in tolerances.
    pub robustness: f64,
    /// Its file.
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

pub const COLUMNS: &[Column<FaultRow>] = &[
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

impl FaultRow {
    /// A fault with the judgement of its worst run. It has its name, the unit of its size, its runs, and those that
    /// broke a requirement.
    pub fn new(
        (fault, size_unit): (&str, &'static str),
        worst: &Judged,
        (runs, broken): (usize, usize),
    ) -> Self {
        Self {
            fault: fault.to_owned(),
            runs,
            broken,
            size: None,
            size_unit,
            for_s: None,
            at_s: None,
            holds_on: None,
            requirement: worst.requirement.clone(),
            margin: worst.margin,
            unit: worst.unit.clone(),
            robustness: worst.value,
            file: None,
            repeat: None,
            text: String::new(),
            severity: 2.0,
        }
    }

    /// The order of the table: what breaks with the least, then what comes nearest to it.
    pub fn rank(&self, other: &Self) -> Ordering {
        let broken = |row: &Self| row.broken == 0;
        broken(self)
            .cmp(&broken(other))
            .then(self.severity.total_cmp(&other.severity))
            .then(self.robustness.total_cmp(&other.robustness))
    }
}
