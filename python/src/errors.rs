//! timegap's errors as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    timegap,
    ScenarioError,
    PyValueError,
    "A scenario, a key or a value is wrong. The message shows the place and what was expected."
);
create_exception!(
    timegap,
    RunError,
    PyRuntimeError,
    "A run cannot begin, or its results cannot be read."
);

/// An error of timegap's: of the scenario, or of the run.
pub fn raise(error: &group::Error) -> PyErr {
    match error {
        group::Error::Scenario(error) => ScenarioError::new_err(error.to_string()),
        group::Error::OpenScenario(error) => ScenarioError::new_err(error.to_string()),
        error => RunError::new_err(error.to_string()),
    }
}
