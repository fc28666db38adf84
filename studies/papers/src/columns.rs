//! The columns of the figures, for continuous integration and the schema. Console and page group them by set and
//! kind ([`super::console`], [`super::page`]).

use super::row::{Row, Verdict};
use super::tally::in_words;
use super::{Paper, Reproduction};
use report::results::{
    Column, Document, Format, Kind, Schema, Table, column, count, flag, nested, number, word,
};
use serde_json::json;

/// Fields of the JSON.
const FIELDS: &[Column<Reproduction>] = &[
    flag("ok", "", ("ok", "OUTSIDE"), "Every compared figure is within its tolerance"),
    count("processes_sample.runs", "", "Runs that were repeated as separate processes"),
    count("processes_sample.different", "", "Repeated runs whose messages were other bytes"),
];

/// What programs see of a paper.
const PAPERS: &[Column<Paper>] = &[
    word("paper", "", "Name of the paper's controller"),
    nested("tally", Kind::List, "Figures of each kind within their tolerance, each counted once"),
    nested("rows", Kind::List, "The figures"),
];

/// Columns of the figures.
const ROWS: &[Column<Row>] = &[
    word("id", "figure", "Scenario and figure; the same in all sets"),
    word("set", "set", "Variant of law, scene and weights"),
    word("kind", "kind", "Source of the expected value"),
    number("expected", "expected", "", 2, "Expected value"),
    number("ours", "ours", "", 2, "Our value; null where the run never got there"),
    number("tolerance", "tolerance", "", 2, "Largest accepted difference"),
    word("unit", "unit", "Unit of the numbers"),
    column("", "verdict", "", Format::Verdict(verdict_words), "Within the tolerance").of(|row| {
        match row.verdict() {
            Verdict::Within => json!("within"),
            Verdict::Outside => json!("outside"),
            Verdict::Shown => json!(null),
        }
    }),
];

fn verdict_words(name: &str) -> (&'static str, bool) {
    if name == "outside" { ("OUTSIDE", false) } else { ("within", true) }
}

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    Schema::new("reproduce", "Figures of the papers beside ours").fields(FIELDS).rows(
        "papers",
        "The papers",
        PAPERS,
    )
}

/// The document of a reproduction.
pub fn document(reproduction: &Reproduction) -> Document {
    let papers = reproduction.papers.iter();
    let words = papers.clone().map(|paper| format!("{}: {}", paper.paper, in_words(&paper.tally)));
    let verdict = words.collect::<Vec<_>>().join("; ");
    let document = Document::new("reproduce", "Reproduction of the papers", reproduction)
        .about("every run in lockstep")
        .verdict(reproduction.ok, verdict);
    papers.fold(document, |document, paper| {
        document.table(Table::new(paper.paper, ROWS, &paper.rows))
    })
}

#[cfg(test)]
mod tests {
    use super::super::row::{paper, within};
    use super::*;
    use frame::batch::ProcessesSample;

    #[test]
    fn a_figure_outside_its_tolerance_is_a_failed_case() {
        let row = |ours| Row::near("A.x", "s", paper(4.0), Some(ours), within(0.1, "a reason"));
        let rows = vec![row(4.0), row(3.0)];
        let tally = super::super::tally::tally(&rows);
        let paper = Paper { paper: "cacc", tally, rows, drives: Vec::new(), pictures: Vec::new() };
        let processes_sample = ProcessesSample::default();
        let papers = vec![paper];
        let found = Reproduction { schema_version: 1, ok: false, papers, processes_sample };
        let document = document(&found);
        assert!(document.junit().contains("<failure"), "{}", document.junit());
        assert!(document.markdown().contains("OUTSIDE"), "{}", document.markdown());
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
