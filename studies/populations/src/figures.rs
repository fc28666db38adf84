//! Figures over drives, declared once each: a column and its value over some drives.

use report::figures::{INTERVENTIONS, Values};
use report::results::Column;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use supervise::RequirementVerdict;
use supervise::report::Outcome;

/// Drives with something in common.
#[derive(Debug)]
pub struct Drives<'a, F> {
    /// What they have in common: names of the group's labels with their values.
    pub labels: Vec<(String, String)>,
    pub all: Vec<&'a Drive<F>>,
}

impl<F> Drives<'_, F> {
    /// The value of a label that the row has.
    pub fn label(&self, name: &str) -> Option<&str> {
        self.labels.iter().find(|(label, _)| label == name).map(|(_, value)| value.as_str())
    }

    /// Number of the drives of which something holds.
    pub fn count(&self, holds: impl Fn(&Drive<F>) -> bool) -> usize {
        self.all.iter().filter(|drive| holds(drive)).count()
    }

    /// Share of these among those.
    pub fn share(
        &self,
        these: impl Fn(&Drive<F>) -> bool,
        those: impl Fn(&Drive<F>) -> bool,
    ) -> f64 {
        self.count(|drive| those(drive) && these(drive)) as f64 / self.count(those).max(1) as f64
    }

    pub fn sum(&self, of: impl Fn(&Drive<F>) -> f64) -> f64 {
        self.all.iter().map(|drive| of(drive)).sum()
    }

    /// Mean over the drives that have the value; not a number without any.
    pub fn mean(&self, of: impl Fn(&Drive<F>) -> Option<f64>) -> f64 {
        let values: Vec<f64> = self.all.iter().filter_map(|drive| of(drive)).collect();
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// Largest of the values that are there, at least 0.
    pub fn most(&self, of: impl Fn(&Drive<F>) -> Option<f64>) -> f64 {
        self.all.iter().filter_map(|drive| of(drive)).fold(0.0, f64::max)
    }

    /// The value that this share of those that have one does not exceed.
    pub fn quantile(&self, share: f64, of: impl Fn(&Drive<F>) -> Option<f64>) -> Option<f64> {
        let mut values: Vec<f64> = self.all.iter().filter_map(|drive| of(drive)).collect();
        values.sort_by(f64::total_cmp);
        let place = ((share * values.len() as f64).ceil() as usize).saturating_sub(1);
        values.get(place).copied().filter(|value| value.is_finite())
    }
}

#[derive(Clone)]
pub struct Figure<F> {
    /// Its column; its name is the path of the value in the JSON.
    pub column: Column<Value>,
    /// Its value; null where it does not apply.
    pub of: fn(&Drives<'_, F>) -> Value,
}

pub const fn figure<F>(column: Column<Value>, of: fn(&Drives<'_, F>) -> Value) -> Figure<F> {
    Figure { column, of }
}

/// Declares figures: `column => |drives| value;`.
macro_rules! figures {
    ($($column:expr => $of:expr;)+) => {
        vec![$($crate::figures::figure($column, $of)),+]
    };
}
pub(crate) use figures;

/// A table with a row for all drives that have the same labels.
pub struct Group<F> {
    /// Name of its rows in the JSON.
    pub name: &'static str,
    pub title: &'static str,
    /// Columns of the labels; the rows of several labels stand in blocks of the first.
    pub labels: Vec<Column<Value>>,
    /// Labels of the rows in which a drive counts.
    pub rows_of: fn(&Drive<F>) -> Vec<Vec<String>>,
    pub figures: Vec<Figure<F>>,
}

impl<F> Group<F> {
    pub fn columns(&self) -> Vec<Column<Value>> {
        let figures = self.figures.iter().map(|figure| figure.column.clone());
        self.labels.iter().cloned().chain(figures).collect()
    }

    /// Its rows, in the order in which the drives have them; rows of one block stand together.
    pub fn rows(&self, drives: &[Drive<F>]) -> Vec<Value> {
        let names = || self.labels.iter().map(|label| label.head.name.to_string());
        let mut rows: Vec<Drives<'_, F>> = Vec::new();
        for drive in drives {
            for values in (self.rows_of)(drive) {
                let labels: Vec<(String, String)> = names().zip(values).collect();
                match rows.iter_mut().find(|row| row.labels == labels) {
                    Some(row) => row.all.push(drive),
                    None => rows.push(Drives { labels, all: vec![drive] }),
                }
            }
        }
        if self.labels.len() > 1 {
            let blocks: Vec<_> = rows.iter().map(|row| row.labels[0].clone()).collect();
            rows.sort_by_key(|row| blocks.iter().position(|block| *block == row.labels[0]));
        }
        let row = |row: &Drives<'_, F>| {
            let labels = row.labels.iter().cloned();
            let mut map: Map<String, Value> =
                labels.map(|(name, value)| (name, Value::from(value))).collect();
            values(&self.figures, row, &mut map);
            Value::Object(map)
        };
        rows.iter().map(row).collect()
    }
}

/// Adds the figures over drives to an object, each at its path.
pub fn values<F>(figures: &[Figure<F>], drives: &Drives<'_, F>, into: &mut Map<String, Value>) {
    for Figure { column, of } in figures {
        let (path, value) = (column.head.name.as_ref(), of(drives));
        match path.split_once('.') {
            None => drop(into.insert(path.to_owned(), value)),
            Some((of, name)) => {
                let below = into.entry(of).or_insert_with(|| Value::Object(Map::new()));
                below[name] = value;
            }
        }
    }
}

/// A drive of a population, before it is driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    pub number: usize,
    /// Law that drives; empty: the scene's own.
    pub law: String,
    /// Values of the population's keys.
    pub keys: Vec<String>,
}

impl Planned {
    /// The drive in words.
    pub fn name(&self) -> String {
        let keys = self.keys.iter().filter(|key| !key.is_empty());
        let keys: Vec<&str> = keys.map(String::as_str).collect();
        let name = format!("{} {}", keys.join(" "), self.number);
        let law = if self.law.is_empty() { String::new() } else { format!(", {}", self.law) };
        format!("{}{law}", name.trim())
    }
}

/// A drive and what the judge found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Drive<F> {
    #[serde(flatten)]
    pub planned: Planned,
    pub outcome: Outcome,
    pub aborted_because: Option<String>,
    pub duration_s: f64,
    pub figures: Values,
    pub requirements: Vec<RequirementVerdict>,
    #[serde(flatten)]
    pub facts: F,
}

impl<F> Drive<F> {
    /// Interventions of the emergency brake.
    pub fn interventions(&self) -> u64 {
        self.figures.get(&INTERVENTIONS).map_or(0, |times| times as u64)
    }

    /// How the run ended, in words.
    pub fn outcome_words(&self) -> String {
        let word = report::print::outcome_word(self.outcome).to_lowercase();
        self.aborted_because.as_ref().map_or_else(|| word.clone(), |why| format!("{word}: {why}"))
    }

    #[cfg(test)]
    pub fn example(law: &str, keys: &[&str], facts: F) -> Self {
        let keys = keys.iter().map(|key| (*key).to_owned()).collect();
        Self {
            planned: Planned { number: 1, law: law.to_owned(), keys },
            outcome: Outcome::Completed,
            aborted_because: None,
            duration_s: 1_800.0,
            figures: Values::default(),
            requirements: Vec::new(),
            facts,
        }
    }
}
