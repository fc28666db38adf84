//! A string of cars, driven one after another.

use crate::errors::ScenarioError;
use crate::run::Driven;
use crate::scenario::Scenario;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use string::CarByCar;

/// A string of which some cars were driven.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct CarString(Mutex<CarByCar>);

impl CarString {
    fn string(&self) -> MutexGuard<'_, CarByCar> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl CarString {
    /// A string of `vehicles` cars; the scenarios, one a law, are repeated along it.
    #[new]
    fn new(laws: Vec<Py<Scenario>>, vehicles: usize) -> PyResult<Self> {
        if laws.is_empty() || vehicles == 0 {
            return Err(PyValueError::new_err("a string needs a law and a car"));
        }
        let laws = laws.iter().map(|scenario| scenario.get().0.clone()).collect();
        Ok(Self(Mutex::new(CarByCar::new(laws, vehicles))))
    }

    /// The scenario of the next car; none when all were driven.
    fn next(&self) -> PyResult<Option<Scenario>> {
        let next = self.string().next();
        next.map(|scenario| scenario.map(Scenario))
            .map_err(|error| ScenarioError::new_err(error.to_string()))
    }

    /// Takes the drive of the car that was next.
    fn drove(&self, scenario: &Scenario, driven: &Driven) {
        self.string().drove(&scenario.0, &driven.summary, &driven.drive);
    }

    /// The results as JSON, in the form of `timegap string --json`.
    fn results(&self) -> String {
        self.string().results().to_string()
    }
}
