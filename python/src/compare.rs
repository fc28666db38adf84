//! Figures of a comparison over its seeds.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Means and differences of runs, as JSON; `rows` is the list `rows` of the command's JSON.
#[pyfunction]
pub fn over_seeds(rows: &str) -> PyResult<String> {
    let found = grid::compare::over_seeds(rows);
    found.map(|found| found.to_string()).map_err(|error| PyValueError::new_err(error.to_string()))
}
