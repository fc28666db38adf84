//! A row of the table of minimal cases.

use report::results::{Column, Format, column, count, judged, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value as Json, json};

use crate::minimal::Held;
use crate::problem::{Problem, Value};
use crate::value::Judged;

/// A minimal case.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FailureRow {
    /// Its file.
    pub file: String,
    /// Value in tolerances.
    pub robustness: f64,
    /// The requirement that it breaks.
    pub requirement: String,
    /// Margin in its unit.
    pub margin: Option<f64>,
    /// The unit.
    pub unit: String,
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

pub const COLUMNS: &[Column<FailureRow>] = &[
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

fn held(row: &FailureRow) -> Json {
    let [failed, tried] = row.holds_on;
    json!({"text": format!("{failed} of {tried}"), "ok": null})
}

impl FailureRow {
    /// A case with these values.
    pub fn new(
        problem: &Problem,
        values: &[Value],
        held: &Held,
        (group, from_run): (usize, usize),
    ) -> Self {
        let nothing =
            || Judged { value: 0.0, requirement: String::new(), margin: None, unit: String::new() };
        let judged = held.first.as_ref().map_or_else(nothing, |(_, judged)| judged.clone());
        let named = problem.variables.iter().zip(values);
        let differs = named.clone().filter(|(variable, value)| variable.nominal != **value);
        let differs: Vec<String> =
            differs.map(|(variable, value)| format!("{} = {value}", variable.name)).collect();
        let values = named.map(|(variable, value)| (variable.name.clone(), json!(value)));
        Self {
            file: String::new(),
            robustness: judged.value,
            requirement: judged.requirement,
            margin: judged.margin,
            unit: judged.unit,
            holds_on: [held.failed, held.tried],
            differs: if differs.is_empty() { "nothing".to_owned() } else { differs.join(", ") },
            values: values.collect(),
            runs: group,
            from_run: from_run + 1,
            repeat: String::new(),
            text: String::new(),
        }
    }
}
