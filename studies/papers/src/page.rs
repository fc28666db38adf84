//! The page of a reproduction: the expected figures beside ours, and what was driven for them.

use super::row::{Row, Verdict};
use super::tally::{in_words, tally};
use super::{Gallery, Paper, Reproduction};
use report::chart::{escape, number};
use report::html::{Cell, Column, document, figure, section, table};
use report::run_pictures;

/// Meaning of the kinds.
const SOURCES: &str = "<p class=\"quiet\">Kinds: <b>paper</b>, printed by the paper; \
    <b>reconstruction</b>, from a reference implementation of what the paper does not print; \
    <b>requirement</b>, demanded of the controller. A figure counts as within its tolerance \
    where it is within it in every set.</p>\n";

/// The page.
pub fn page(reproduction: &Reproduction) -> String {
    let papers: String = reproduction.papers.iter().map(paper).collect();
    let verdict = reproduction.papers.iter().map(in_short).collect::<Vec<_>>().join("; ");
    document(
        "Reproduction of the papers",
        "every run in lockstep",
        reproduction.ok,
        &verdict,
        &(overview(&reproduction.papers) + SOURCES + &papers),
    )
}

/// The printed figures of a paper that come out.
fn in_short(paper: &Paper) -> String {
    format!("{}: {}", paper.paper, in_words(&paper.tally))
}

/// Every set with its figures, and the rows that are outside their tolerance.
fn overview(papers: &[Paper]) -> String {
    let head = [
        ("paper", Column::Text),
        ("set", Column::Text),
        ("within their tolerance", Column::Text),
        ("outside", Column::Text),
    ];
    let mut rows = Vec::new();
    for paper in papers {
        for set in sets(&paper.rows) {
            let outside = set.iter().filter(|row| row.verdict() == Verdict::Outside);
            let outside: Vec<_> = outside.map(|row| row.id.as_str()).collect();
            rows.push(vec![
                Cell::Plain(paper.paper.into()),
                Cell::Plain(set[0].set.clone()),
                Cell::Plain(in_words(&tally(set))),
                Cell::Bad(outside.join(", ")),
            ]);
        }
    }
    section("What comes out", &table(&head, &rows))
}

/// The rows of a paper, set by set.
fn sets(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| a.set == b.set)
}

fn paper(paper: &Paper) -> String {
    let tables: String = sets(&paper.rows)
        .map(|rows| {
            let heading = &rows[0].set;
            let heading = match heading.as_str() {
                "" => String::new(),
                set => format!("<h3>{}</h3>\n", escape(set)),
            };
            heading + &rows_of_a_set(rows)
        })
        .collect();
    section(&in_short(paper), &(pictures(paper) + &tables + &drives(paper)))
}

/// Columns of a set's table; one in which every cell is empty is left out.
const COLUMNS: [(&str, Column); 11] = [
    ("figure", Column::Text),
    ("kind", Column::Text),
    ("expected", Column::Number),
    ("ours", Column::Number),
    ("unit", Column::Text),
    ("tolerance", Column::MoreNumber),
    ("", Column::Text),
    ("source", Column::MoreText),
    ("inferred value behind it", Column::MoreText),
    ("note", Column::MoreText),
    ("reason of the tolerance", Column::MoreText),
];

fn rows_of_a_set(rows: &[Row]) -> String {
    let rows: Vec<_> = rows.iter().map(cells).collect();
    let is_empty = |cell: &Cell| *cell == Cell::Plain(String::new());
    let is_shown = |column: usize| rows.iter().any(|row| !is_empty(&row[column]));
    let shown: Vec<usize> = (0..COLUMNS.len()).filter(|column| is_shown(*column)).collect();
    let head: Vec<_> = shown.iter().map(|&column| COLUMNS[column]).collect();
    let cells = |row: &[Cell; 11]| shown.iter().map(|&column| row[column].clone()).collect();
    table(&head, &rows.iter().map(cells).collect::<Vec<_>>())
}

fn cells(row: &Row) -> [Cell; 11] {
    let value = |value: Option<f64>| value.map_or_else(|| "–".into(), |value| number(value, 2));
    let text = |text: Option<&str>| Cell::Plain(text.unwrap_or_default().into());
    let verdict = match row.verdict() {
        Verdict::Within => Cell::Good("within".into()),
        Verdict::Outside => Cell::Bad("OUTSIDE".into()),
        Verdict::Shown => Cell::Plain(String::new()),
    };
    [
        Cell::Plain(row.id.clone()),
        Cell::Plain(row.kind.name().into()),
        Cell::Plain(row.expectation()),
        Cell::Plain(value(row.ours)),
        Cell::Plain(row.unit.into()),
        Cell::Plain(row.tolerance_in_words()),
        verdict,
        text(row.source),
        text(row.inferred),
        text(row.note),
        text(row.tolerance_reason),
    ]
}

/// The paper's own pictures.
fn pictures(paper: &Paper) -> String {
    let gallery = |gallery: &Gallery| {
        let plots: String = gallery.plots.iter().map(|plot| figure(plot)).collect();
        format!("<h3>{}</h3>\n<div class=\"columns\">{plots}</div>\n", escape(&gallery.heading))
    };
    paper.pictures.iter().map(gallery).collect()
}

/// The drives, folded where there are many.
fn drives(paper: &Paper) -> String {
    let open = if paper.drives.len() <= 3 { " open" } else { "" };
    paper
        .drives
        .iter()
        .map(|(what, run)| {
            format!(
                "<details class=\"drive\"{open}><summary>{}</summary>\n{}</details>\n",
                escape(what),
                run_pictures(run)
            )
        })
        .collect()
}
