//! The rows of a test as they are found: figures with their limits.

use group::DriveStep;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::limits::Limit;

/// A figure of a test with its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The control law.
    pub law: String,
    /// The test.
    pub test: Cow<'static, str>,
    /// Name of the figure.
    pub figure: Cow<'static, str>,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// The value; null if the measured event did not happen.
    pub value: Option<f64>,
    /// Least value allowed.
    pub least: Option<f64>,
    /// Largest value allowed.
    pub most: Option<f64>,
    /// True if the value is inside its limits.
    pub ok: bool,
}

/// The rows of a test as they are found.
pub(super) struct Sheet<'a> {
    pub(super) law: &'a str,
    pub(super) rows: Vec<Row>,
}

impl Sheet<'_> {
    pub(super) fn at_least(
        &mut self,
        (test, figure, unit): (&'static str, &'static str, &'static str),
        value: Option<f64>,
        least: f64,
    ) {
        let ok = value.is_some_and(|value| value >= least);
        self.push(Row { value, least: Some(least), ok, ..self.row(test, figure, unit) });
    }

    pub(super) fn at_most(
        &mut self,
        (test, figure, unit): (&'static str, &'static str, &'static str),
        value: Option<f64>,
        most: f64,
    ) {
        let ok = value.is_some_and(|value| value <= most);
        self.push(Row { value, most: Some(most), ok, ..self.row(test, figure, unit) });
    }

    /// A mean over a window against a limit over speed.
    pub(super) fn within(
        &mut self,
        names: (&'static str, &'static str, &'static str),
        limit: Limit,
        steps: &[DriveStep],
        quantity: impl Fn(&DriveStep) -> f64,
    ) {
        let worst = limit.worst(steps, quantity);
        let most = worst.map_or_else(|| limit.at(0.0), |worst| worst.limit);
        self.at_most(names, worst.map(|worst| worst.mean), most);
    }

    fn row(&self, test: &'static str, figure: &'static str, unit: &'static str) -> Row {
        Row {
            law: self.law.to_owned(),
            test: test.into(),
            figure: figure.into(),
            unit: unit.into(),
            value: None,
            least: None,
            most: None,
            ok: false,
        }
    }

    fn push(&mut self, row: Row) {
        self.rows.push(row);
    }
}
