//! Means over the seeds, with their spread.

use group::report::Outcome;
use report::print;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::{Map, Value, json};
use statistics::Spread;

use super::row::Row;
use crate::figure::{self, ALL, COUNT};

/// A law in a scenario, over its seeds.
#[derive(Debug, Serialize)]
pub struct Means {
    pub scenario: String,
    pub controller: String,
    pub runs: usize,
    /// Runs that reached the scenario's end.
    pub completed: usize,
    pub figures: Spreads,
    #[serde(skip)]
    ended: String,
}

/// The figures by their names, each with its spread.
#[derive(Debug)]
pub struct Spreads([Spread; COUNT]);

impl Serialize for Spreads {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COUNT))?;
        for (figure, Spread { mean, deviation, n }) in ALL.iter().zip(self.0) {
            let spread = json!({"mean": mean, "deviation": deviation, "n": n});
            map.serialize_entry(figure.name(), &spread)?;
        }
        map.end()
    }
}

/// The means of each scenario and law, in the order of the rows.
pub fn means(rows: &[Row]) -> Vec<Means> {
    let same = |a: &Row, b: &Row| (&a.scenario, &a.controller) == (&b.scenario, &b.controller);
    rows.chunk_by(same).map(Means::of).collect()
}

impl Means {
    fn of(rows: &[Row]) -> Self {
        let values: Vec<figure::Values> = rows.iter().map(figure::values).collect();
        let spread = |place: usize| {
            let of: Vec<f64> = values.iter().filter_map(|values| values[place]).collect();
            Spread::of(&of)
        };
        Self {
            scenario: rows[0].scenario.clone(),
            controller: rows[0].controller.clone(),
            runs: rows.len(),
            completed: rows.iter().filter(|row| row.outcome == Outcome::Completed).count(),
            figures: Spreads(std::array::from_fn(spread)),
            ended: print::outcomes(rows.iter().map(|row| row.outcome)),
        }
    }

    /// The row for people: n stands beside a mean of fewer seeds.
    pub fn shown(&self) -> Value {
        let mut row = Map::new();
        for (figure, Spread { mean, deviation, n }) in ALL.iter().zip(self.figures.0) {
            let n = (n != self.runs).then_some(n);
            let shown = json!({"mean": mean, "deviation": deviation, "n": n});
            // A figure that no seed has is left out.
            row.insert(figure.name().to_owned(), mean.map_or(Value::Null, |_| shown));
        }
        let ok = self.completed == self.runs;
        row.insert("scenario".to_owned(), json!(self.scenario));
        row.insert("controller".to_owned(), json!(self.controller));
        row.insert("ended".to_owned(), json!({"text": self.ended, "ok": ok}));
        Value::Object(row)
    }
}
