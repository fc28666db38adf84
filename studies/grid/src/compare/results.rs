//! The result of a comparison, for every output.

use std::collections::BTreeMap;

use report::results::{Document, Schema};
use report::summary::braked;
use report::{RunPicture, overlay};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};
use supervise::report::Outcome;

use super::columns;
use super::differences::{Difference, differences, rule};
use crate::row::{Point, Row, interventions, points};

/// Laws side by side on the same scenarios.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Comparison {
    pub schema_version: u32,
    /// Every run reached its end without a collision or a red light.
    pub ok: bool,
    /// A row for each scenario, law and seed.
    pub rows: Vec<Row>,
    /// A row for each scenario and law, over its seeds.
    pub means: Vec<Means>,
    /// Each law against the first one, seed by seed; empty for one seed.
    pub differences: Vec<Difference>,
    /// Rule for a real difference; null for one seed.
    pub rule: Option<String>,
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
pub fn document(rows: Vec<Row>, seeds: usize, drives: Vec<(String, String)>) -> Document {
    let completed = rows.iter().filter(|row| row.outcome == Outcome::Completed).count();
    let ok = completed == rows.len();
    let (means, differences) = (means(&rows), differences(&rows));
    let rule = rule(&differences);
    let mut verdict = format!(
        "{completed} of {} runs completed; {}{}",
        rows.len(),
        braked(interventions(&rows)),
        backup(&rows)
    );
    if !differences.is_empty() {
        let real = differences.iter().filter(|difference| difference.is_real()).count();
        verdict += &format!("; {real} of {} differences are real", differences.len());
    }
    let about = rows.first().map_or("", |row| row.mode.as_str()).to_owned();
    let about = match seeds {
        1 => about,
        seeds => format!("{about}, {seeds} seeds each (mean ± standard deviation)"),
    };
    let whole = Comparison { schema_version: 1, ok, rows, means, differences, rule };
    let table = match seeds {
        1 => columns::runs(&whole.rows),
        _ => columns::means(&points(&whole.rows)),
    };
    let table = drives.into_iter().fold(table, |table, (of, html)| table.figures(&of, html));
    let mut document = Document::new("compare", "Comparison of controllers", &whole)
        .about(about)
        .verdict(ok, verdict)
        .table(table);
    if seeds > 1 {
        for table in columns::differences(&whole.differences) {
            document = document.table(table);
        }
        document = document
            .text(whole.rule.clone().unwrap_or_default())
            .table(columns::runs_with_seeds(&whole.rows).for_pages());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    #[test]
    fn time_gaps_are_shown_and_columns_without_a_figure_are_not() {
        let rows = vec![row("acc-mpc", 1, 20.0), row("six-mode", 1, -0.001)];
        let document = document(rows, 1, Vec::new());
        for text in [document.console(80), document.page(), document.markdown()] {
            for heading in ["min time gap, s", "median time gap, s", "gap error rms, m"] {
                assert!(text.contains(heading), "{heading}: {text}");
            }
            for heading in ["fuel", "missed", "gap error at the end", "real"] {
                assert!(!text.contains(heading), "{heading}: {text}");
            }
            assert!(!text.contains("-0.0") && !text.contains("−0.0"), "{text}");
        }
        let wrong = report::results::check(&schema().json(), &document.value());
        assert_eq!(wrong, [""; 0]);
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
        let console = document(rows, 1, Vec::new()).console(100);
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
        let document = document(rows, 12, Vec::new());
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
        let wrong = report::results::check(&schema().json(), &json);
        assert_eq!(wrong, [""; 0]);
        let rows = json["rows"].to_string();
        let again = over_seeds(&rows).expect("the rows of a result");
        for part in ["means", "differences", "rule"] {
            assert_eq!(again[part], json[part], "{part}");
        }
    }
}
