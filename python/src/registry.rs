//! Lists of scenarios, laws and figures.

use controller::laws::own;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use report::figures::{ALL, Figure, Measured, Values};
use report::summary::{Control, LawAccount, Timing};
use scenario::builtin;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// The built-in scenarios: name and description.
#[pyfunction]
pub fn scenarios() -> Vec<(&'static str, &'static str)> {
    builtin::ALL.iter().map(|builtin| (builtin.name, builtin.summary())).collect()
}

/// timegap's own laws: name, description, source, and whether they drive trucks alone.
#[pyfunction]
pub fn laws() -> Vec<(&'static str, &'static str, &'static str, bool)> {
    own().map(|law| (law.name, law.description, law.source, law.trucks_alone)).collect()
}

/// The figures of a drive in the order of `runs.csv`: name, unit (empty for a count), decimals, weight, meaning.
#[pyfunction]
pub fn figures() -> Vec<(&'static str, &'static str, usize, u8, &'static str)> {
    let of = |figure: &Figure| {
        (figure.name, figure.unit, figure.decimals, figure.weight, figure.meaning)
    };
    ALL.iter().map(of).collect()
}

/// The figures of a run by its `summary.json`: name, and the value where the figure applies.
#[pyfunction]
pub fn figures_of(summary: &str) -> PyResult<Vec<(&'static str, Option<f64>)>> {
    let mut summary: Value = serde_json::from_str(summary).map_err(wrong)?;
    let mut take = |name: &str| summary[name].take();
    let (control, timing): (Control, Timing) = (part(take("control"))?, part(take("timing"))?);
    let (law, aebs): (Option<LawAccount>, Value) = (part(take("law"))?, take("aebs"));
    let values = Values::of(Measured {
        control: &control,
        timing: &timing,
        law: law.as_ref(),
        warnings: aebs["warnings"].as_u64(),
        interventions: aebs["interventions"].as_u64(),
        braking_s: aebs["braking_s"].as_f64(),
    });
    Ok(values.iter().map(|(figure, value)| (figure.name, value)).collect())
}

fn part<T: DeserializeOwned>(value: Value) -> PyResult<T> {
    serde_json::from_value(value).map_err(wrong)
}

fn wrong(error: serde_json::Error) -> PyErr {
    PyValueError::new_err(format!("not a summary of a run: {error}"))
}
