//! The columns of the figures, for every output.

use report::results::{Column, Format, Schema, Table, column, number, word};
use serde::Serialize;
use serde_json::{Value, json};

use super::row::{self, Row, Verdict};
use super::{Paper, Reproduction};

const ROWS: &[Column<Row>] = &[
    word("set", "set", "Variant of law, scene and weights").of(|row| json!(row.set)),
    word("id", "figure", "Scenario and figure; the same in all sets"),
    word(
        "kind",
        "kind",
        "Source of the expected value: paper, reconstruction, requirement or input",
    )
    .weight(1),
    number("ours", "ours", "", 2, "Our value; null where the run never got there"),
    word("", "expected", "Expected value").of(|row| json!(row.expectation())),
    word("", "tolerance", "Largest accepted difference")
        .of(|row: &Row| json!(row.tolerance_in_words()))
        .weight(2),
    word("unit", "unit", "Unit of the numbers"),
    column("", "verdict", "", Format::Verdict(verdict_words), "Within the tolerance").of(verdict),
    word("source", "source", "Sentence, figure or equation of the paper, shortened").weight(4),
    word("inferred", "inferred value behind it", "Inferred value that the row depends on")
        .weight(3),
    word("note", "note", "Origin of ours, or a remark").weight(4),
    word("tolerance_reason", "reason of the tolerance", "Why the tolerance is that large")
        .weight(5),
];

/// A set of a paper at a glance.
#[derive(Serialize)]
struct Line {
    paper: &'static str,
    set: String,
    from_paper: Option<String>,
    reconstruction: Option<String>,
    requirement: Option<String>,
    /// Ids of the rows outside their tolerance.
    outside: Option<Value>,
}

const LINES: &[Column<Line>] = &[
    word("paper", "paper", "Name of the paper's controller"),
    word("set", "set", "Variant of law, scene and weights"),
    word("from_paper", "paper", "Figures that the paper prints, within their tolerance"),
    word("reconstruction", "reconstruction", "Figures of the reconstruction, within it"),
    word("requirement", "requirement", "Requirements that are met"),
    column("outside", "outside", "", Format::Judged, "Figures outside their tolerance").weight(1),
];

fn verdict(row: &Row) -> Value {
    match row.verdict() {
        Verdict::Within => json!("within"),
        Verdict::Outside => json!("outside"),
        Verdict::Shown => json!(null),
    }
}

fn verdict_words(name: &str) -> (&'static str, bool) {
    if name == "outside" { ("OUTSIDE", false) } else { ("within", true) }
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Reproduction>("reproduce")
}

/// The rows of a paper, in a block for each set.
pub fn rows(paper: &Paper) -> Table {
    Table::new(paper.paper, ROWS, &paper.rows).blocks("set")
}

/// Every set with its counts, and the rows outside their tolerance.
pub fn overview(papers: &[Paper]) -> Table {
    let lines = papers.iter().flat_map(|paper| {
        paper.rows.chunk_by(|a, b| a.set == b.set).map(|rows| Line::of(paper.paper, rows))
    });
    Table::new("Figures within their tolerance", LINES, &lines.collect::<Vec<_>>())
        .blocks("paper")
        .without_cases()
}

impl Line {
    fn of(paper: &'static str, rows: &[Row]) -> Self {
        let tally = super::tally::tally(rows);
        let of_kind = |kind: row::Kind| {
            let tally = tally.iter().find(|tally| tally.kind == kind)?;
            Some(format!("{} of {}", tally.in_every_set, tally.figures))
        };
        let outside = rows.iter().filter(|row| row.verdict() == Verdict::Outside);
        let outside: Vec<_> = outside.map(|row| row.id.as_str()).collect();
        Self {
            paper,
            set: rows[0].set.clone(),
            from_paper: of_kind(row::Kind::Paper),
            reconstruction: of_kind(row::Kind::Reconstruction),
            requirement: of_kind(row::Kind::Requirement),
            outside: (!outside.is_empty())
                .then(|| json!({"text": outside.join(", "), "ok": false})),
        }
    }
}
