//! Lists of scenarios and laws.

use controller::laws::own;
use pyo3::prelude::*;
use scenario::builtin;

/// The built-in scenarios: name and description.
#[pyfunction]
pub fn scenarios() -> Vec<(&'static str, &'static str)> {
    builtin::ALL.iter().map(|builtin| (builtin.name, builtin.summary)).collect()
}

/// timegap's own laws: name, description, source, and whether they drive trucks alone.
#[pyfunction]
pub fn laws() -> Vec<(&'static str, &'static str, &'static str, bool)> {
    own().map(|law| (law.name, law.description, law.source, law.trucks_alone)).collect()
}
