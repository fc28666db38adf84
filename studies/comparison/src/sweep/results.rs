//! The result of a sweep: every run, and every point folded over its seeds.

use crate::figure::{self, ALL, COUNT, Folded, Values};
use frame::param::Param;
use group::report::Outcome;
use group::{Error, RequirementVerdict};
use report::print;
use report::results::{
    Column, Format, Kind, Schema, Table, count, judged, nested, number, outcome, word,
};
use report::summary::Summary;
use report::verdicts;
use runtime::Mode;
use serde::de::{Deserialize, Deserializer};
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// The whole sweep.
#[derive(Debug, serde::Serialize)]
pub struct Sweep {
    schema_version: u32,
    pub ok: bool,
    pub scenario: String,
    /// Controllers of the runs: one, unless the controller is swept.
    pub controllers: Vec<String>,
    pub mode: &'static str,
    /// Swept keys.
    pub params: Vec<String>,
    /// The grid's points that were reached, in its order.
    pub points: Vec<Point>,
    /// Every run, in the grid's order.
    pub runs: Vec<Run>,
}

/// A point of the grid, folded over its seeds.
#[derive(Debug, serde::Serialize)]
pub struct Point {
    pub values: Vec<String>,
    pub seeds: usize,
    /// Runs that reached the scenario's end.
    pub completed: usize,
    pub figures: Figures,
    /// Spread of each figure over the seeds.
    pub spread: Spread,
    /// Least margin of each requirement.
    pub requirements: Vec<RequirementVerdict>,
    #[serde(skip)]
    ended: String,
}

/// Spread of the figures over the seeds, by their names.
#[derive(Clone, Copy, Debug)]
pub struct Spread([Folded; COUNT]);

impl Serialize for Spread {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COUNT))?;
        for (figure, Folded { spread, .. }) in ALL.iter().zip(self.0) {
            let statistics::Spread { deviation, n, .. } = spread;
            map.serialize_entry(figure.name(), &json!({"deviation": deviation, "n": n}))?;
        }
        map.end()
    }
}

/// One run.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Run {
    values: Vec<String>,
    seed: u64,
    pub outcome: Outcome,
    /// Reason why the outcome is `aborted`.
    aborted_because: Option<String>,
    /// Verdicts on the requirements.
    #[serde(default)]
    requirements: Vec<RequirementVerdict>,
    figures: Figures,
}

/// Figures by their names in results.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures(pub Values);

impl Serialize for Figures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COUNT))?;
        for (figure, value) in ALL.iter().zip(self.0) {
            map.serialize_entry(figure.name(), &value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Figures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let named = BTreeMap::<String, Option<f64>>::deserialize(deserializer)?;
        let value = |index: usize| named.get(ALL[index].name()).copied().flatten();
        Ok(Self(std::array::from_fn(value)))
    }
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    let fields: [Column<()>; 5] = [
        frame::ok("Every run reached its end without a collision or a red light"),
        word("scenario", "", "Scenario that was driven"),
        nested("controllers", Kind::List, "Laws that drove"),
        word("mode", "", "Clock of the runs"),
        nested("params", Kind::List, "Keys that were swept"),
    ];
    let figures =
        || ALL.iter().map(|figure| of_json(figure, &format!("figures.{}", figure.name())));
    let point = [
        nested("values", Kind::List, "Value of each key"),
        count("seeds", "", "Runs of the point"),
        count("completed", "", "Runs that reached their end"),
        nested("requirements", Kind::List, "Verdict on each requirement with its least margin"),
    ];
    let spread = ALL.iter().flat_map(|figure| {
        let at = |what: &str| format!("spread.{}.{what}", figure.name());
        let unit = figure.column.head.unit;
        let deviation = number("", "", unit, 2, "Standard deviation over the seeds");
        let n = count("", "", "Seeds in which the figure applies");
        [deviation.named(at("deviation"), String::new()), n.named(at("n"), String::new())]
    });
    let run = [
        nested("values", Kind::List, "Value of each key"),
        count("seed", "", "Seed of the run"),
        outcome("outcome"),
        word("aborted_because", "", "Why the run was aborted"),
        nested("requirements", Kind::List, "Verdicts on the requirements, as in summary.json"),
    ];
    Schema::new("sweep", "Figures as functions of keys")
        .fields(&fields)
        .rows(
            "points",
            "A row for each point of the grid",
            &point.into_iter().chain(figures()).chain(spread).collect::<Vec<_>>(),
        )
        .rows("runs", "A row for each run", &run.into_iter().chain(figures()).collect::<Vec<_>>())
}

/// The column of a figure in JSON: a count of several seeds has decimals.
fn of_json(figure: &figure::Figure, path: &str) -> Column<Value> {
    let heading = figure.column.head.heading.to_string();
    let mut column = figure.column.clone().named(path.to_owned(), heading);
    column.head.format = Format::Decimals(2);
    column
}

/// The column of the requirements' margins, in words.
fn margins() -> Column<Value> {
    word("margins", "requirements", "Margins of the requirements")
}

/// A row with its margins in words.
fn with_margins(mut row: Value, of: &[RequirementVerdict]) -> Value {
    row["margins"] = json!(verdicts::words(of));
    row
}

impl Run {
    /// A run with these keys set: a seed among them is not a value.
    pub fn new(keys: &[String], seed: u64, result: Result<Summary, Error>) -> Self {
        let values = keys.iter().filter_map(|key| key.split_once('='));
        let values = values.filter(|(key, _)| *key != "seed").map(|(_, value)| value.to_owned());
        let values = values.collect();
        match result {
            Ok(summary) => Self {
                values,
                seed,
                figures: Figures(figure::values(&summary)),
                outcome: summary.outcome,
                aborted_because: summary.aborted_because,
                requirements: summary.requirements,
            },
            Err(error) => Self {
                values,
                seed,
                figures: Figures::default(),
                outcome: Outcome::Aborted,
                aborted_because: Some(error.to_string()),
                requirements: Vec::new(),
            },
        }
    }
}

impl Sweep {
    /// Interventions of the emergency brake in all runs.
    pub fn interventions(&self) -> u64 {
        let place = ALL.iter().position(|figure| figure.name() == figure::INTERVENTIONS);
        let place = place.expect("it is one of the figures");
        self.runs.iter().filter_map(|run| run.figures.0[place]).map(|times| times as u64).sum()
    }

    /// The rules that a run can break, in words.
    pub fn rules(&self) -> &'static str {
        match self.runs.iter().any(|run| !run.requirements.is_empty()) {
            true => "a collision, a red light or a broken requirement",
            false => "a collision or a red light",
        }
    }

    /// Puts the runs, in the grid's order, together.
    pub fn new(
        scenario: &str,
        controllers: Vec<String>,
        mode: Mode,
        params: &[Param],
        runs: Vec<Run>,
    ) -> Self {
        let points = runs.chunk_by(|a, b| a.values == b.values).map(|seeds| {
            let folded: [Folded; COUNT] = std::array::from_fn(|index| {
                ALL[index].fold.over(seeds.iter().map(|run| run.figures.0[index]))
            });
            let verdicts = seeds.iter().map(|run| (String::new(), run.requirements.as_slice()));
            let requirements = verdicts::least(verdicts).into_iter().map(|least| least.verdict);
            Point {
                requirements: requirements.collect(),
                values: seeds[0].values.clone(),
                seeds: seeds.len(),
                completed: seeds.iter().filter(|run| run.outcome == Outcome::Completed).count(),
                figures: Figures(folded.map(|folded| folded.value)),
                spread: Spread(folded),
                ended: print::outcomes(seeds.iter().map(|run| run.outcome)),
            }
        });
        Self {
            schema_version: 1,
            ok: runs.iter().all(|run| run.outcome == Outcome::Completed),
            scenario: scenario.into(),
            controllers,
            mode: mode.name(),
            params: params.iter().map(|param| param.key.clone()).collect(),
            points: points.collect(),
            runs,
        }
    }

    /// Columns of the swept keys.
    fn keys(&self) -> impl Iterator<Item = Column<Value>> {
        let key = |(place, key): (usize, &String)| {
            count("", "", "Value of the key").named(format!("values.{place}"), key.clone())
        };
        self.params.iter().enumerate().map(key)
    }

    /// One line for each run; a figure that does not apply is empty.
    pub fn csv(&self) -> String {
        let figures =
            ALL.iter().map(|figure| of_json(figure, &format!("figures.{}", figure.name())));
        let columns = self.keys().chain([count("seed", "", ""), outcome("outcome")]).chain(figures);
        let columns = columns.chain([margins()]);
        let rows = self.runs.iter().map(|run| with_margins(json!(run), &run.requirements));
        Table::new("Runs", &columns.collect::<Vec<_>>(), &rows.collect::<Vec<_>>()).csv()
    }

    /// One row for each point. A mean has its spread, and its n where a figure does not apply in every run.
    pub fn table(&self) -> Table {
        let figures = ALL.iter().map(|figure| {
            let mut column = of_json(figure, figure.name());
            column.head.format = Format::Mean(2);
            column
        });
        let ended = judged("ended", "outcome", "How the runs ended");
        let columns: Vec<_> =
            self.keys().chain([ended]).chain(figures).chain([margins()]).collect();
        let rows = self.points.iter().map(|point| {
            let mut row = Map::new();
            for (figure, Folded { value, spread }) in ALL.iter().zip(point.spread.0) {
                let shown = match (figure.fold, spread.deviation) {
                    (figure::Fold::Mean, Some(deviation)) => {
                        let n = (spread.n != point.seeds).then_some(spread.n);
                        json!({"mean": value, "deviation": deviation, "n": n})
                    }
                    _ => json!(value),
                };
                row.insert(figure.name().to_owned(), shown);
            }
            row.insert("values".to_owned(), json!(point.values));
            let ok = point.completed == point.seeds;
            row.insert("ended".to_owned(), json!({"text": point.ended, "ok": ok}));
            with_margins(Value::Object(row), &point.requirements)
        });
        Table::new("Points", &columns, &rows.collect::<Vec<_>>())
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
