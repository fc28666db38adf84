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
pub fn raise(error: &supervise::Error) -> PyErr {
    // The exception's name says that it is an error.
    let words = error.to_string();
    let words = words.strip_prefix("error: ").unwrap_or(&words).to_owned();
    match error {
        supervise::Error::Scenario(_) => ScenarioError::new_err(words),
        _ => RunError::new_err(words),
    }
}
