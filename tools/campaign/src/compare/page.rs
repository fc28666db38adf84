//! The page of a comparison: a table and the drives over each other, scenario by scenario.

use super::Row;
use report::chart::number;
use report::html::{Cell, Column, document, section, table};
use report::overlay;
use report::print;
use runtime::report::Outcome;

/// The page.
pub fn page(rows: &[Row]) -> String {
    let completed = rows.iter().filter(|row| row.outcome == Outcome::Completed).count();
    let verdict = format!("{completed} of {} runs without a collision or a red light", rows.len());
    let scenarios: String = rows.chunk_by(|a, b| a.scenario == b.scenario).map(scenario).collect();
    let about = rows.first().map_or("", |row| row.mode);
    document("Comparison of controllers", about, completed == rows.len(), &verdict, &scenarios)
}

fn scenario(rows: &[Row]) -> String {
    let head = [
        ("controller", Column::Text),
        ("outcome", Column::Text),
        ("min gap, m", Column::Number),
        ("min TTC, s", Column::Number),
        ("gap off at the end, m", Column::MoreNumber),
        ("acceleration, m/s²", Column::MoreNumber),
        ("jerk, m/s³", Column::MoreNumber),
        ("fuel, L/100 km", Column::MoreNumber),
        ("law p50", Column::MoreNumber),
        ("law p99", Column::MoreNumber),
        ("missed", Column::MoreNumber),
    ];
    let cells: Vec<_> = rows.iter().map(cells).collect();
    let runs: Vec<_> = rows.iter().map(|row| (row.controller.as_str(), &row.picture)).collect();
    let name = rows.first().map_or("", |row| row.scenario.as_str());
    section(name, &format!("{}<div class=\"gap\"></div>{}", table(&head, &cells), overlay(&runs)))
}

fn cells(row: &Row) -> Vec<Cell> {
    let control = &row.control.figures;
    let dash = || "–".to_owned();
    let figure = |value: Option<f64>, decimals| {
        Cell::Plain(value.map_or_else(dash, |value| number(value, decimals)))
    };
    let range = control.min_accel_mps2.zip(control.max_accel_mps2);
    let range =
        range.map_or_else(dash, |(low, high)| format!("{} to {}", number(low, 2), number(high, 2)));
    let law = |us: Option<f64>| Cell::Plain(us.map_or_else(dash, print::duration));
    let word = print::outcome_word(row.outcome).to_owned();
    vec![
        Cell::Plain(row.controller.clone()),
        if row.outcome == Outcome::Completed { Cell::Good(word) } else { Cell::Bad(word) },
        figure(control.min_gap_m, 1),
        figure(control.min_ttc_s, 1),
        figure(control.final_gap_error_m, 1),
        Cell::Plain(range),
        figure(control.max_abs_jerk_mps3, 1),
        figure(control.fuel_l_per_100km, 2),
        law(row.timing.solve_us.map(|p| p.p50)),
        law(row.timing.solve_us.map(|p| p.p99)),
        Cell::Plain(row.timing.deadline_misses.map_or_else(dash, |misses| misses.to_string())),
    ]
}
