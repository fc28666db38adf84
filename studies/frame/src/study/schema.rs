//! Fields that the JSON of every study has, declared once.

use report::results::{Column, Schema, count, flag};

use crate::batch::ProcessesSample;

/// The repeated sample, below `processes_sample`.
const SAMPLE: &[Column<ProcessesSample>] = &[
    count("processes_sample.runs", "", "Runs that were repeated as separate processes"),
    count("processes_sample.different", "", "Repeated runs whose messages were other bytes"),
];

/// The schema of a study's result with the fields that all studies have. The study adds its own.
///
/// ```
/// use report::results::{Column, check, count};
///
/// const FIELDS: &[Column<()>] = &[frame::ok("Every gap is above 2 m"), count("runs", "", "Runs")];
/// let schema = frame::schema("gaps", "Gaps of the laws").fields(FIELDS).json();
/// let sample = serde_json::json!({"runs": 3, "different": 0});
/// let result = serde_json::json!({"schema_version": 1, "ok": true, "runs": 7, "processes_sample": sample});
/// assert_eq!(check(&schema, &result), [""; 0]);
/// ```
#[must_use]
pub fn schema(command: &'static str, meaning: &str) -> Schema {
    Schema::new(command, meaning).fields(SAMPLE)
}

/// The field `ok`: the verdict over all runs. `meaning` says when it is true.
#[must_use]
pub const fn ok<R>(meaning: &'static str) -> Column<R> {
    flag("ok", "", ("ok", "BROKEN"), meaning)
}
