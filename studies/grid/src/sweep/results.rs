//! The result of a sweep: every run, and every point folded over its seeds.

use std::collections::BTreeMap;

use report::figures::{Figure, compared};
use report::results::{Column, Object, Schema, Table, count, judged, value, word};
use runtime::Mode;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};
use supervise::RequirementVerdict;
use supervise::report::Outcome;

use crate::row::{Point, Row, points};

/// Figures as functions of keys.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Sweep {
    schema_version: u32,
    /// Every run reached its end without a collision or a red light.
    pub ok: bool,
    /// Scenario that was driven.
    pub scenario: String,
    /// Laws that drove: one, unless the controller is swept.
    pub controllers: Vec<String>,
    /// Clock of the runs.
    pub mode: &'static str,
    /// Keys that were swept.
    pub params: Vec<String>,
    /// A row for each point of the grid that was reached, in its order.
    pub points: Vec<Folded>,
    /// A row for each run, in the grid's order.
    pub runs: Vec<Row>,
}

/// A point of the grid, folded over its seeds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Folded {
    /// Value of each key.
    pub values: Vec<String>,
    /// Runs of the point.
    pub seeds: usize,
    /// Runs that reached their end.
    pub completed: usize,
    /// Each figure: its mean, or the worst of the seeds.
    pub figures: Map<String, Value>,
    /// Deviation of each figure over the seeds, and the number of seeds that have it.
    pub spread: Map<String, Value>,
    /// Verdict on each requirement with its least margin.
    #[schemars(with = "Vec<Object>")]
    pub requirements: Vec<RequirementVerdict>,
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Sweep>("sweep")
}

impl Folded {
    fn of(point: Point<'_>) -> Self {
        Self {
            values: point.rows[0].values.clone(),
            seeds: point.rows.len(),
            completed: point.completed,
            figures: point.figures(|folded| json!(folded.value)),
            spread: point.figures(
                |folded| json!({"deviation": folded.spread.deviation, "n": folded.spread.n}),
            ),
            requirements: point.requirements,
        }
    }
}

impl Sweep {
    /// Puts the runs, in the grid's order, together.
    pub fn new(
        scenario: &str,
        controllers: Vec<String>,
        mode: Mode,
        params: Vec<String>,
        runs: Vec<Row>,
    ) -> Self {
        Self {
            schema_version: 1,
            ok: runs.iter().all(|run| run.outcome == Outcome::Completed),
            scenario: scenario.into(),
            controllers,
            mode: mode.name(),
            params,
            points: points(&runs).into_iter().map(Folded::of).collect(),
            runs,
        }
    }

    /// The rules that a run can break, in words.
    pub fn rules(&self) -> &'static str {
        match self.runs.iter().any(|run| !run.requirements.is_empty()) {
            true => "a collision, a red light or a broken requirement",
            false => "a collision or a red light",
        }
    }

    /// One row for each point.
    pub fn table(&self) -> Table {
        let key = |(place, key): (usize, &String)| -> Column<Value> {
            value("", "", "Value of the key").named(format!("values.{place}"), key.clone())
        };
        let ended = judged("ended", "outcome", "How the runs ended");
        let seeds = count("seeds", "", "Runs of the point").hidden();
        let margins = word("margins", "requirements", "Margins of the requirements");
        let keys = self.params.iter().enumerate().map(key);
        let columns = keys.chain([ended, seeds]).chain(compared().map(Figure::folded));
        let columns: Vec<_> = columns.chain([margins]).collect();
        let row = |point: &Point<'_>| {
            let mut row = point.shown(false);
            row.insert("values".to_owned(), json!(point.rows[0].values));
            Value::Object(row)
        };
        let rows: Vec<Value> = points(&self.runs).iter().map(row).collect();
        Table::new("Points", &columns, &rows)
    }

    /// The line above the table.
    pub fn about(&self) -> String {
        let seeds = self.points.iter().map(|point| point.seeds).max().unwrap_or(0);
        let of_seeds = match seeds {
            0 | 1 => String::new(),
            seeds => format!(", {seeds} seeds each (mean ± standard deviation, or the worst)"),
        };
        let controllers = self.controllers.join(", ");
        let (scenario, mode, points) = (&self.scenario, self.mode, self.points.len());
        format!("{scenario} ({controllers}, {mode}): {points} points{of_seeds}")
    }

    /// Reason why runs were aborted, a line for each reason.
    pub fn reasons(&self) -> String {
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        for why in self.runs.iter().filter_map(|run| run.aborted_because.as_deref()) {
            *reasons.entry(why).or_default() += 1;
        }
        let lines = reasons.iter().map(|(why, runs)| format!("{runs} aborted: {why}"));
        lines.collect::<Vec<_>>().join("\n")
    }
}

#[cfg(test)]
mod tests;
