//! The tables of a comparison.

use report::figures::{
    CYCLES_BY_BACKUP, DEADLINE_MISSES, FINAL_GAP_ERROR_M, Figure, MAX_ACCEL_MPS2, compared,
};
use report::results::{Column, Table, count, judged, micros, number, outcome, word};
use report::verdicts;
use serde_json::{Value, json};

use super::differences::Difference;
use crate::row::{Point, Row};

/// Figures of a run beside the compared ones.
const ALSO: [Figure; 3] = [FINAL_GAP_ERROR_M, MAX_ACCEL_MPS2, CYCLES_BY_BACKUP];

/// Columns of the runs; the seed has a place among them where there are several.
fn of_runs(has_seeds: bool) -> Vec<Column<Row>> {
    let seed = count("seed", "seed", "Seed of the run");
    // The columns before the outcome name the run.
    let (outcome, seed) = (outcome("outcome"), if has_seeds { seed } else { seed.hidden() });
    let [third, fourth] = if has_seeds { [seed, outcome] } else { [outcome, seed] };
    let names = [
        word("scenario", "scenario", "Scenario that was driven"),
        word("controller", "law", "Control law that drove"),
        third,
        fourth,
    ];
    let figures = compared().copied().filter(|figure| figure.name != DEADLINE_MISSES.name);
    let rest = [
        word("", "energy", "Whether energy and fuel can be compared with other trips")
            .weight(3)
            .of(energy),
        micros("timing.solve_us.p50", "law p50", "Median time inside the law, µs").weight(4),
        micros("timing.solve_us.p99", "law p99", "99th percentile of the time inside the law, µs")
            .weight(4),
        DEADLINE_MISSES.of(|row: &Row| &row.figures),
        word("", "requirements", "Margins of the requirements")
            .of(|row| json!(verdicts::words(&row.requirements))),
    ];
    let figures = figures.chain(ALSO).map(|figure| figure.of(|row: &Row| &row.figures));
    names.into_iter().chain(figures).chain(rest).collect()
}

fn energy(row: &Row) -> Value {
    let trip = row.parts.as_ref().map(|parts| &parts.control.trip);
    match trip.and_then(|trip| trip.energy_is_comparable) {
        Some(false) => json!("not comparable: too short"),
        _ => json!(null),
    }
}

/// Columns of the differences from the first law.
const DIFFERENCES: &[Column<Difference>] = &[
    word("scenario", "scenario", ""),
    word("controller", "law", ""),
    word("", "figure", "").of(|difference| json!(difference.title)),
    number("mean", "difference", "", 3, ""),
    number("low", "from", "", 3, "").weight(1),
    number("high", "to", "", 3, "").weight(1),
    count("n", "n", "").weight(2),
    word("", "law is", "").of(|difference| json!(difference.verdict())),
];

/// The runs as a table with a block for each scenario.
pub fn runs(rows: &[Row]) -> Table {
    Table::new("Runs", &of_runs(false), rows).blocks("scenario")
}

/// The runs of several seeds, whose seeds belong to their names.
pub fn runs_with_seeds(rows: &[Row]) -> Table {
    Table::new("Runs", &of_runs(true), rows)
}

/// The means as a table with a block for each scenario.
pub fn means(points: &[Point<'_>]) -> Table {
    let names: [Column<Value>; 3] = [
        word("scenario", "scenario", ""),
        word("controller", "law", ""),
        judged("ended", "outcome", "How the runs ended"),
    ];
    let columns: Vec<_> = names.into_iter().chain(compared().map(Figure::folded)).collect();
    let row = |point: &Point<'_>| {
        let mut row = point.shown(true);
        row.insert("scenario".to_owned(), json!(point.rows[0].scenario));
        row.insert("controller".to_owned(), json!(point.rows[0].controller));
        Value::Object(row)
    };
    let rows: Vec<Value> = points.iter().map(row).collect();
    Table::new("Means", &columns, &rows).blocks("scenario").without_cases()
}

/// The real differences for a terminal, and all of them for pages.
pub fn differences(all: &[Difference]) -> Vec<Table> {
    let Some(reference) = all.first().map(|difference| &difference.reference) else {
        return Vec::new();
    };
    let real: Vec<&Difference> = all.iter().filter(|difference| difference.is_real()).collect();
    let real = Table::new(&format!("Real differences from {reference}"), DIFFERENCES, real);
    let all = Table::new(&format!("All differences from {reference}"), DIFFERENCES, all);
    vec![real.for_terminals().without_cases(), all.for_pages().without_cases()]
}
