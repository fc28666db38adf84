//! Rows of numbers from a table or a bag, with the place of each for errors.

use super::columns::{Column, Columns};
use super::keys::CsvFile;
use crate::quantity::OutOfRange;
use crate::reading::csv::Table;
use crate::{Problem, Refusal, ScenarioError};
use bags::{BagError, BagFault, Series};
use openscenario::instant_s;
use std::path::Path;

/// Rows of a record. Column 0 holds the times.
pub(super) enum Source<'a> {
    /// Lines of a table: their numbers and the numbers of the columns.
    Lines {
        table: Table<'a>,
        rows: Vec<usize>,
        columns: Vec<usize>,
    },
    Messages {
        path: &'a str,
        topic: &'a str,
        series: Series,
        has_time: bool,
    },
}

impl<'a> Source<'a> {
    pub(super) fn lines(
        source: &'a str,
        text: &'a str,
        keys: &CsvFile,
        columns: &Columns,
    ) -> Result<Self, Refusal> {
        let table = Table::split(source, text);
        let names: Vec<&Column> = columns.time.iter().chain(&columns.of_motion).collect();
        let all = names.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(",");
        let is_empty = text.trim().is_empty()
            || (table.len() == 0 && names.iter().any(|column| table.find(&column.name).is_some()));
        if is_empty {
            return Err(ScenarioError::whole(source, "no values")
                .expecting(format!("a line `{all}` and at least one line of numbers"))
                .into());
        }
        let has = |column: &&Column| table.find(&column.name).is_some();
        if keys.columns.is_none() && !names.iter().all(has) {
            let (message, found) = (format!("{source} has no columns `{all}`"), table.names());
            let found = found.collect::<Vec<_>>().join(", ");
            let expected = format!("t=NAME, v=NAME:UNIT or positions, of {found}");
            return Err(Problem::new("columns", message, expected).into());
        }
        let places = names.iter().map(|column| table.column(&column.name, &all));
        let columns = places.collect::<Result<Vec<_>, _>>()?;
        let rows: Vec<usize> = match &keys.rows {
            None => (0..table.len()).collect(),
            Some(rows) => {
                let (name, value) = rows.split_once('=').ok_or_else(|| {
                    let message = format!("`{rows}` chooses no rows");
                    Problem::new("rows", message, "column=value")
                })?;
                let column = table.column(name.trim(), &all)?;
                let is_chosen = |row: &usize| table.text(*row, column) == Some(value.trim());
                (0..table.len()).filter(is_chosen).collect()
            }
        };
        if rows.is_empty() {
            let chosen = keys.rows.as_deref().unwrap_or_default();
            let message = format!("no row of {source} has {chosen}");
            return Err(Problem::new("rows", message, "a value that the column has").into());
        }
        Ok(Self::Lines { table, rows, columns })
    }

    pub(super) fn messages(
        path: &'a str,
        keys: &'a CsvFile,
        columns: &Columns,
    ) -> Result<Self, Refusal> {
        let topic = keys.topic.as_deref().ok_or_else(|| {
            let topics = bags::topics(Path::new(path)).map_err(|error| refused(path, &error));
            let names = topics.map(|topics| topics.into_iter().map(|topic| topic.name));
            names.map_or_else(Refusal::from, |names| {
                let names = names.collect::<Vec<_>>().join(", ");
                Problem::new("topic", "a bag without a topic", format!("one of {names}")).into()
            })
        })?;
        if keys.rows.is_some() {
            let message = "a bag has a topic for each vehicle";
            return Err(Problem::new("rows", message, "no `rows` beside a bag").into());
        }
        let names = columns.time.iter().chain(&columns.of_motion);
        let fields: Vec<String> = names.map(|column| column.name.clone()).collect();
        let series = bags::series(Path::new(path), topic, &fields).map_err(|error| {
            let key = match error.kind {
                BagFault::Topic => "topic",
                BagFault::Field => "columns",
                BagFault::File => return Refusal::from(refused(path, &error)),
            };
            let expected = error.expected.unwrap_or_else(|| "another topic".to_owned());
            Refusal::from(Problem::new(key, format!("{path}: {}", error.message), expected))
        })?;
        Ok(Self::Messages { path, topic, series, has_time: columns.time.is_some() })
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Lines { rows, .. } => rows.len(),
            Self::Messages { series, .. } => series.rows.len(),
        }
    }

    /// The number in a field. It may be NaN.
    pub(super) fn number(&self, row: usize, column: usize) -> Result<f64, ScenarioError> {
        match self {
            Self::Lines { table, rows, columns } => table.float(rows[row], columns[column]),
            Self::Messages { series, has_time, .. } => {
                let row = &series.rows[row];
                Ok(match (has_time, column) {
                    (true, _) => row.values[column],
                    (false, 0) => row.log_time_s(),
                    (false, _) => row.values[column - 1],
                })
            }
        }
    }

    /// The stamp of a row in units of `factor` s, and whether it counts from 1970: a number does not, and a date and
    /// time of ISO 8601 does. Without a zone it is UTC.
    pub(super) fn stamp(&self, row: usize, factor: f64) -> Result<(f64, bool), ScenarioError> {
        let date = match self {
            Self::Lines { table, rows, columns } => {
                table.text(rows[row], columns[0]).and_then(instant_s)
            }
            Self::Messages { .. } => None,
        };
        match date {
            Some(seconds) => Ok((seconds / factor, true)),
            None => Ok((self.number(row, 0)?, matches!(self, Self::Messages { .. }))),
        }
    }

    pub(super) fn refusal(
        &self,
        row: usize,
        column: usize,
        message: &str,
        expected: impl Into<String>,
    ) -> ScenarioError {
        let error = match self {
            Self::Lines { table, rows, columns } => {
                table.fault(rows[row], columns[column], message)
            }
            Self::Messages { path, topic, .. } => {
                let place = format!("message {} of topic {topic}: {message}", row + 1);
                ScenarioError::whole(path, place)
            }
        };
        error.expecting(expected)
    }

    /// An error at a number outside its range.
    pub(super) fn out_of_range(
        &self,
        row: usize,
        column: usize,
        refused: &OutOfRange<f64>,
    ) -> ScenarioError {
        let message = format!("{} is out of range", refused.value);
        self.refusal(row, column, &message, refused.range.to_string())
    }
}

fn refused(path: &str, error: &BagError) -> ScenarioError {
    ScenarioError::whole(path, &*error.message)
        .expecting(error.expected.clone().unwrap_or_default())
}
