//! The page of a comparison: a table and the drives over each other, scenario by scenario.

use super::{Row, columns};
use report::html::{Cell, Column, document, section, table};
use report::overlay;
use report::print;
use report::summary::braked;
use runtime::report::Outcome;

/// The page.
pub fn page(rows: &[Row]) -> String {
    let completed = rows.iter().filter(|row| row.outcome == Outcome::Completed).count();
    let braked = braked(rows.iter().filter_map(|row| row.aebs.interventions).sum());
    let verdict =
        format!("{completed} of {} runs without a collision or a red light; {braked}", rows.len());
    let scenarios: String = rows.chunk_by(|a, b| a.scenario == b.scenario).map(scenario).collect();
    let about = rows.first().map_or("", |row| row.mode.as_str());
    document("Comparison of controllers", about, completed == rows.len(), &verdict, &scenarios)
}

fn scenario(rows: &[Row]) -> String {
    let columns = columns::shown(rows);
    let figures = columns.iter().map(|column| {
        (column.heading, if column.more { Column::MoreNumber } else { Column::Number })
    });
    let head: Vec<_> = [("controller", Column::Text), ("outcome", Column::Text)]
        .into_iter()
        .chain(figures)
        .collect();
    let cells: Vec<Vec<Cell>> = (rows.iter())
        .map(|row| {
            let word = print::outcome_word(row.outcome).to_owned();
            let outcome = match row.outcome {
                Outcome::Completed => Cell::Good(word),
                _ => Cell::Bad(word),
            };
            let figures = columns.iter().map(|column| Cell::Plain(column.cell(row)));
            [Cell::Plain(row.controller.clone()), outcome].into_iter().chain(figures).collect()
        })
        .collect();
    let runs: Vec<_> = rows.iter().map(|row| (row.controller.as_str(), &row.picture)).collect();
    // Parts of a comparison keep figures alone.
    let is_drawn = rows.iter().all(|row| !row.picture.position_m.is_empty());
    let drives = if is_drawn { overlay(&runs) } else { String::new() };
    let name = rows.first().map_or("", |row| row.scenario.as_str());
    section(name, &format!("{}<div class=\"gap\"></div>{drives}", table(&head, &cells)))
}
