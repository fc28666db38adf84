//! The result of a comparison, for every output.

use super::against::Against;
use super::differences::{Difference, columns, differences, rule};
use crate::row::{Point, Row, interventions, points};
use report::figures::{
    CYCLES_BY_BACKUP, DEADLINE_MISSES, FINAL_GAP_ERROR_M, Figure, MAX_ACCEL_MPS2, compared,
};
use report::results::{Column, Document, Schema, Table, count, judged, micros, outcome, word};
use report::summary::braked;
use report::{RunPicture, overlay, verdicts};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use supervise::report::Outcome;

/// Laws side by side on the same scenarios.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Comparison {
    pub schema_version: u32,
    /// Every run reached its end without a collision or a red light. With a baseline: nothing got worse.
    pub ok: bool,
    /// A row for each scenario, law and seed.
    pub rows: Vec<Row>,
    /// A row for each scenario and law, over its seeds.
    pub means: Vec<Means>,
    /// Each law against the first one, seed by seed; empty for one seed.
    pub differences: Vec<Difference>,
    /// Rule for a real difference; null for one seed.
    pub rule: Option<String>,
    /// The runs against those of `--against`; null without it.
    pub against: Option<Against>,
}

/// A law in a scenario, over its seeds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Means {
    /// Scenario that was driven.
    pub scenario: String,
    /// Control law that drove.
    pub controller: String,
    /// Runs, one a seed.
    pub runs: usize,
    /// Runs that reached the scenario's end.
    pub completed: usize,
    /// Each figure with its mean, deviation and number of seeds.
    pub figures: Map<String, Value>,
}

/// The means of each scenario and law, in the order of the rows.
fn means(rows: &[Row]) -> Vec<Means> {
    let means = |point: Point<'_>| Means {
        scenario: point.rows[0].scenario.clone(),
        controller: point.rows[0].controller.clone(),
        runs: point.rows.len(),
        completed: point.completed,
        figures: point.figures(|folded| {
            let spread = folded.spread;
            json!({"mean": spread.mean, "deviation": spread.deviation, "n": spread.n})
        }),
    };
    points(rows).into_iter().map(means).collect()
}

/// `means`, `differences` and `rule` of the JSON, of runs that the caller drove. `rows` is the list of the same name.
/// The runs of a scenario stand together, and so do those of a law in it. All have the same seeds in the same order.
///
/// ```
/// let of_nothing = grid::compare::over_seeds("[]").expect("an empty list");
/// assert_eq!(of_nothing["means"], serde_json::json!([]));
/// assert!(grid::compare::over_seeds("[{}]").is_err());
/// ```
pub fn over_seeds(rows: &str) -> serde_json::Result<Value> {
    let rows = Row::read(rows)?;
    let differences = differences(&rows);
    let rule = rule(&differences);
    Ok(json!({"means": means(&rows), "differences": differences, "rule": rule}))
}

/// The drives of each scenario over each other. Parts of a comparison keep figures alone.
pub fn drives(
    rows: &[(usize, Row)],
    seen: &BTreeMap<usize, Option<RunPicture>>,
) -> Vec<(String, String)> {
    let blocks = rows.chunk_by(|(_, a), (_, b)| a.scenario == b.scenario);
    let drawn = blocks.filter_map(|rows| {
        let laws = rows.chunk_by(|(_, a), (_, b)| a.controller == b.controller);
        let pictures = laws.map(|seeds| {
            let (run, row) = &seeds[0];
            Some((row.controller.as_str(), seen.get(run)?.as_ref()?))
        });
        let pictures: Vec<_> = pictures.collect::<Option<_>>()?;
        Some((rows[0].1.scenario.clone(), overlay(&pictures)))
    });
    drawn.collect()
}

/// The result for every output.
pub fn document(
    rows: Vec<Row>,
    seeds: usize,
    drives: Vec<(String, String)>,
    against: Option<Against>,
) -> Document {
    let completed = rows.iter().filter(|row| row.outcome == Outcome::Completed).count();
    let ok = against.as_ref().map_or(completed == rows.len(), Against::holds);
    let (means, differences) = (means(&rows), differences(&rows));
    let rule = rule(&differences);
    let mut verdict = format!(
        "{completed} of {} runs completed; {}{}",
        rows.len(),
        braked(interventions(&rows)),
        backup(&rows)
    );
    if !differences.is_empty() {
        let real = differences.iter().filter(|difference| difference.judged.is_real()).count();
        verdict += &format!("; {real} of {} differences are real", differences.len());
    }
    if let Some(against) = &against {
        verdict = format!("{verdict}; {}", against.verdict());
    }
    let about = rows.first().map_or("", |row| row.mode.as_str()).to_owned();
    let about = match seeds {
        1 => about,
        seeds => format!("{about}, {seeds} seeds each (mean ± standard deviation)"),
    };
    let whole = Comparison { schema_version: 1, ok, rows, means, differences, rule, against };
    let table = match seeds {
        1 => Table::new("Runs", &of_runs(false), &whole.rows).blocks("scenario"),
        _ => means_table(&points(&whole.rows)),
    };
    // With a baseline a run that does not complete is no failure by itself.
    let table = if whole.against.is_some() { table.without_cases() } else { table };
    let table = drives.into_iter().fold(table, |table, (of, html)| table.figures(&of, html));
    let mut document = Document::new("compare", "Comparison of controllers", &whole)
        .about(about)
        .verdict(ok, verdict)
        .table(table);
    if seeds > 1 {
        for table in difference_tables(&whole.differences) {
            document = document.table(table);
        }
        document = document
            .text(whole.rule.clone().unwrap_or_default())
            .table(Table::new("Runs", &of_runs(true), &whole.rows).for_pages());
    }
    if let Some(against) = &whole.against {
        document = against.tables().into_iter().fold(document, Document::table);
        document = document.text(against.rule.clone().unwrap_or_default());
    }
    document
}

/// Laws of the user's that their backups drove for, at least a while, in words.
fn backup(rows: &[Row]) -> String {
    let laws = rows.iter().filter_map(|row| Some((row, row.parts.as_ref()?.law.as_ref()?)));
    let by_backup = laws.filter(|(_, law)| law.backup > 0 && law.refused.is_some());
    let by_backup: Vec<_> =
        by_backup.map(|(row, law)| format!("{law} in {}", row.scenario)).collect();
    match by_backup.as_slice() {
        [] => String::new(),
        [first] => format!("; {first}"),
        [first, rest @ ..] => {
            format!("; {first}, and the backup drove in {} more runs", rest.len())
        }
    }
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Comparison>("compare")
}

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

/// The means as a table with a block for each scenario.
pub fn means_table(points: &[Point<'_>]) -> Table {
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
pub fn difference_tables(all: &[Difference]) -> Vec<Table> {
    let Some(reference) = all.first().map(|difference| &difference.reference) else {
        return Vec::new();
    };
    let real: Vec<&Difference> =
        all.iter().filter(|difference| difference.judged.is_real()).collect();
    let real = Table::new(&format!("Real differences from {reference}"), &columns(), real);
    let all = Table::new(&format!("All differences from {reference}"), &columns(), all);
    vec![real.for_terminals().without_cases(), all.for_pages().without_cases()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    #[test]
    fn time_gaps_are_shown_and_columns_without_a_figure_are_not() {
        let rows = vec![row("acc-mpc", 1, 20.0), row("six-mode", 1, -0.001)];
        let document = document(rows, 1, Vec::new(), None);
        for text in [document.console(80), document.page(), document.markdown()] {
            for heading in ["min time gap, s", "median time gap, s", "gap error rms, m"] {
                assert!(text.contains(heading), "{heading}: {text}");
            }
            for heading in ["fuel", "missed", "gap error at the end", "real"] {
                assert!(!text.contains(heading), "{heading}: {text}");
            }
            assert!(!text.contains("-0.0") && !text.contains("−0.0"), "{text}");
        }
        assert!(document.junit().contains("name=\"following, acc-mpc\""), "{}", document.junit());
    }

    #[test]
    fn a_backup_that_drove_a_part_is_on_the_console() {
        let mut rows = vec![row("acc-mpc", 1, 20.0), row("mine", 1, 20.0)];
        let mut law = |row: usize, refused| {
            let parts = rows[row].parts.as_mut().expect("a comparison has them");
            parts.law = Some(report::summary::LawAccount {
                name: ["acc-mpc", "mine"][row].to_owned(),
                cycles: 600,
                backup: 82,
                refused,
                ..Default::default()
            });
        };
        law(0, None);
        law(1, Some(0));
        let console = document(rows, 1, Vec::new(), None).console(100);
        let said = "; 82 of 600 cycles by the backup, not by mine in following";
        let words: Vec<&str> = console.split_whitespace().collect();
        assert!(words.join(" ").contains(said), "{console}");
    }

    #[test]
    fn several_seeds_show_means_and_real_differences() {
        let of = |law, gap_m: f64| {
            (1..=12).map(move |seed| row(law, seed, gap_m + 0.1 * (seed % 3) as f64))
        };
        let mut rows: Vec<Row> = of("acc-mpc", 20.0).chain(of("six-mode", 15.0)).collect();
        rows[3].outcome = Outcome::Collision;
        let document = document(rows, 12, Vec::new(), None);
        let console = document.console(100);
        for words in ["lockstep, 12 seeds each", "20.10", "± 0.09", "11 completed, 1 COLLISION"] {
            assert!(console.contains(words), "{words}: {console}");
        }
        let (_, real) = console.split_once("Real differences from acc-mpc").expect(&console);
        let table = real.split("A difference is called real").next().expect("the rule follows");
        assert!(table.contains("min gap, m") && table.contains("worse"), "{table}");
        assert!(!table.contains("gap error rms"), "equal figures differ: {table}");
        let (page, json) = (document.page(), document.value());
        assert!(page.contains("All differences from acc-mpc") && page.contains("gap error rms"));
        assert_eq!(json["means"].as_array().map(Vec::len), Some(2));
        let junit = document.junit();
        assert!(junit.contains("name=\"following, acc-mpc, 4\""), "{junit}");
        assert_eq!(junit.matches("<failure").count(), 2, "the run and the verdict: {junit}");
        assert!(json["rule"].as_str().expect("words").contains("Hartigan"));
        let rows = json["rows"].to_string();
        let again = over_seeds(&rows).expect("the rows of a result");
        for part in ["means", "differences", "rule"] {
            assert_eq!(again[part], json[part], "{part}");
        }
    }
}
