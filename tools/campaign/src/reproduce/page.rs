//! The page of a reproduction: the expected figures beside ours, and what was driven for them.

use super::row::{Row, Verdict, tally};
use super::{Gallery, Paper, Reproduction};
use report::chart::{escape, number};
use report::html::{Cell, Column, document, figure, section, table};
use report::run_pictures;

/// What the sources mean.
const SOURCES: &str = "<p class=\"quiet\">Sources: <b>paper</b>, printed by the paper; \
    <b>reconstruction</b>, from a reference implementation of what the paper does not print; \
    <b>requirement</b>, demanded of the controller.</p>\n";

/// The page.
pub fn page(reproduction: &Reproduction) -> String {
    let rows = || reproduction.papers.iter().flat_map(|paper| &paper.rows);
    let compared = rows().filter(|row| row.verdict() != Verdict::Shown).count();
    let within = rows().filter(|row| row.verdict() == Verdict::Within).count();
    let verdict = format!("{within} of {compared} figures within their tolerance");
    let papers: String = reproduction.papers.iter().map(paper).collect();
    document(
        "Reproduction of the papers",
        "every run in lockstep",
        reproduction.ok,
        &verdict,
        &(SOURCES.to_owned() + &papers),
    )
}

fn paper(paper: &Paper) -> String {
    let heading = format!("{}: {}", paper.paper, tally(&paper.rows));
    let several = paper.rows.iter().any(|row| row.weights.is_some());
    let mut head = vec![
        ("figure", Column::Text),
        ("source", Column::Text),
        ("expected", Column::Number),
        ("ours", Column::Number),
        ("unit", Column::Text),
        ("tolerance", Column::MoreNumber),
        ("", Column::Text),
        ("reason of the tolerance", Column::MoreText),
        ("note", Column::MoreText),
    ];
    if several {
        head.insert(1, ("weights", Column::MoreText));
    }
    let rows: Vec<_> = paper.rows.iter().map(|row| cells(row, several)).collect();
    section(&heading, &(table(&head, &rows) + &pictures(paper) + &drives(paper)))
}

fn cells(row: &Row, several: bool) -> Vec<Cell> {
    let value = |value: Option<f64>| value.map_or_else(|| "–".into(), |value| number(value, 2));
    let verdict = match row.verdict() {
        Verdict::Within => Cell::Good("within".into()),
        Verdict::Outside => Cell::Bad("OUTSIDE".into()),
        Verdict::Shown => Cell::Plain(String::new()),
    };
    let mut cells = vec![
        Cell::Plain(row.id.clone()),
        Cell::Plain(row.kind.name().into()),
        Cell::Plain(row.expectation()),
        Cell::Plain(value(row.ours)),
        Cell::Plain(row.unit.into()),
        Cell::Plain(row.tolerance_in_words()),
        verdict,
        Cell::Plain(row.tolerance_reason.unwrap_or_default().into()),
        Cell::Plain(row.note.unwrap_or_default().into()),
    ];
    if several {
        cells.insert(1, Cell::Plain(row.weights.clone().unwrap_or_default()));
    }
    cells
}

/// The paper's own pictures.
fn pictures(paper: &Paper) -> String {
    let gallery = |gallery: &Gallery| {
        let plots: String = gallery.plots.iter().map(|plot| figure(plot)).collect();
        format!("<h3>{}</h3>\n{plots}", escape(&gallery.heading))
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
