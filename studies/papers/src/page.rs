//! The result for every output, and the pictures of its page.

use super::row::{Row, Verdict};
use super::tally::in_words;
use super::{Paper, Reproduction, row};
use crate::runner::{Driven, Gallery, Pictures};
use report::chart::{Axis, Curve, Plot, Stroke, Tone, escape};
use report::html::figure;
use report::results::{Column, Document, Format, Schema, Table, column, number, word};
use report::run_pictures;
use serde::Serialize;
use serde_json::{Value, json};
use supervise::DriveStep;

const KINDS: &str = "<p class=\"quiet\">Kinds: <b>paper</b>, printed by the paper; \
    <b>reconstruction</b>, from a reference implementation of what the paper does not print; \
    <b>requirement</b>, demanded of the controller; <b>input</b>, put in by the scenario or the code, and outside every \
    count. A figure counts as within its tolerance where it is within it in every set.</p>\n";
/// Most drives of a paper that the page shows unfolded.
const UNFOLDED: usize = 3;

pub fn document(reproduction: &Reproduction) -> Document {
    let papers = &reproduction.papers;
    let verdict = papers.iter().map(in_short).collect::<Vec<_>>().join("; ");
    let document = Document::new("reproduce", "Reproduction of the papers", reproduction)
        .about("every run in lockstep")
        .verdict(reproduction.ok, verdict)
        .table(overview(papers))
        .figures("", KINDS.to_owned());
    papers.iter().fold(document, |document, paper| {
        document
            .figures(&in_short(paper), galleries(&paper.pictures))
            .table(rows(paper))
            .figures("", drives(&paper.pictures))
    })
}

/// The figures of a paper that come out.
fn in_short(paper: &Paper) -> String {
    format!("{}: {}", paper.paper, in_words(&paper.tally))
}

/// The paper's own figures.
fn galleries(pictures: &Pictures) -> String {
    let gallery = |gallery: &Gallery| {
        let plots: String = gallery.plots.iter().map(figure).collect();
        format!("<h3>{}</h3>\n<div class=\"columns\">{plots}</div>\n", escape(&gallery.heading))
    };
    pictures.galleries.iter().map(gallery).collect()
}

/// The drives, folded where there are many.
fn drives(pictures: &Pictures) -> String {
    let open = if pictures.drives.len() <= UNFOLDED { " open" } else { "" };
    let drive = |(name, run): &(String, report::RunPicture)| {
        let (name, run) = (escape(name), run_pictures(run));
        format!("<details class=\"drive\"{open}><summary>{name}</summary>\n{run}</details>\n")
    };
    pictures.drives.iter().map(drive).collect()
}

/// One value of some drives over time.
pub fn over_time(
    title: &str,
    unit: &str,
    drives: &[(&str, &Driven)],
    value: &dyn Fn(&Driven) -> Vec<(f64, f64)>,
) -> Plot {
    let ends_s = drives.iter().map(|(_, driven)| driven.scenario.duration_s.value());
    over(title, Axis::time(ends_s.fold(0.0, f64::max)), unit, drives, value)
}

/// One value of some drives over the road to `until_m`.
pub fn over_road(
    title: &str,
    unit: &str,
    until_m: f64,
    drives: &[(&str, &Driven)],
    value: &dyn Fn(&Driven, &DriveStep) -> Option<f64>,
) -> Plot {
    let points = |driven: &Driven| {
        let steps = driven.drive.steps.iter().take_while(|step| step.position_m <= until_m);
        steps.filter_map(|step| Some((step.position_m / 1e3, value(driven, step)?))).collect()
    };
    over(title, Axis::linear("distance, km", 0.0, until_m / 1e3), unit, drives, &points)
}

fn over(
    title: &str,
    x: Axis,
    unit: &str,
    drives: &[(&str, &Driven)],
    points: &dyn Fn(&Driven) -> Vec<(f64, f64)>,
) -> Plot {
    let curve = |(index, (name, driven)): (usize, &(&str, &Driven))| {
        let stroke = if index == 0 { Stroke::Solid } else { Stroke::Dashed };
        Curve::new(name, Tone::Series(index), points(driven)).stroke(stroke)
    };
    Plot::over(title, x, unit, drives.iter().enumerate().map(curve).collect())
}

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

#[cfg(test)]
mod tests {
    use super::super::row::{Row, Tolerance, paper, reconstruction, requirement, within};
    use super::super::study::reproduction;
    use super::*;

    const TENTH: Tolerance = within(0.1, "a reason");

    fn of(name: &'static str, rows: Vec<Row>) -> Document {
        let paper = Paper { paper: name, tally: Vec::new(), rows, pictures: Pictures::default() };
        document(&reproduction(vec![paper]))
    }

    #[test]
    fn a_figure_outside_its_tolerance_is_not_hidden() {
        let row = |ours| Row::near("A.x", "s", paper(4.0), Some(ours), TENTH);
        let document = of("cacc", vec![row(4.0), row(3.0)]);
        assert!(!document.is_ok());
        let text = document.console(80);
        assert!(text.contains("0 of 1") && text.contains("OUTSIDE"), "{text}");
        assert!(document.junit().contains("<failure"), "{}", document.junit());
        assert!(document.markdown().contains("OUTSIDE"), "{}", document.markdown());
    }

    #[test]
    fn a_set_an_inferred_value_and_a_long_id_fit_in_eighty_columns() {
        let id = "dynamic-programming.above_full_route_generated";
        let row = |id| {
            Row::at_most(id, "m/s²", requirement(-123.0), Some(-122.0), TENTH)
                .in_set("joint weights")
                .depending_on("the desired distance keeps its first value, v t_h + d_b = 34.5 m")
                .with_source("a long sentence of the paper that only the page has room for")
                .with_note("a long note that only the page has room for, and the JSON")
        };
        let other = Row::near("y", "", reconstruction(4.0), None, TENTH);
        let document = of("predictive", vec![row(id), row("x"), other]);
        let text = document.console(80);
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("joint weights") && text.contains("≤ −123.00"), "{text}");
        assert!(document.page().contains("34.5 m"), "the page names the inferred value");
    }
}
