//! The page of a sweep: its points and its figures over the swept key.

use super::param::Param;
use super::results::Sweep;
use crate::report::html::{Cell, Column, document, figure, section, table};
use shared::report::Outcome;

/// Most points that the table has; the files have all.
const MAX_ROWS: usize = 500;

/// The page.
pub fn page(sweep: &Sweep, params: &[Param]) -> String {
    let completed = sweep.runs.iter().filter(|run| run.outcome == Outcome::Completed).count();
    let verdict =
        format!("{completed} of {} runs without a collision or a red light", sweep.runs.len());
    let drawn: String = sweep.pictures(params).iter().map(|plot| figure(plot)).collect();
    let pictures = format!("<div class=\"grid\">\n{drawn}</div>\n");
    let body = [section("Figures", &pictures), section("Points", &points(sweep))].concat();
    let title = format!("Sweep of {}", sweep.scenario());
    document(&title, sweep.mode(), completed == sweep.runs.len(), &verdict, &body)
}

fn points(sweep: &Sweep) -> String {
    let (head, rows) = sweep.cells();
    let head: Vec<_> = head.iter().map(|name| (name.as_str(), Column::Number)).collect();
    let left_out = rows.len().saturating_sub(MAX_ROWS);
    let rows: Vec<Vec<Cell>> = rows
        .into_iter()
        .take(MAX_ROWS)
        .map(|row| row.into_iter().map(Cell::Plain).collect())
        .collect();
    let note = if left_out > 0 {
        format!("<p class=\"quiet\">and {left_out} more in sweep.csv</p>\n")
    } else {
        String::new()
    };
    table(&head, &rows) + &note
}
