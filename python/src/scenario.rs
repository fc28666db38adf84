//! A scenario with its keys set.

use crate::errors::{ScenarioError, raise};
use pyo3::prelude::*;
use scenario::quantity::Seed;
use scenario::{Setting, option_value};
use supervise::{Error, LawOptions, LawSource, NamedLaw, ScenarioOptions};

fn refuse(error: scenario::ScenarioError) -> PyErr {
    raise(&Error::from(error))
}

/// A scenario, read and checked.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct Scenario(pub scenario::Scenario);

#[pymethods]
impl Scenario {
    /// Opens a built-in scenario or a file. `set` are arguments of `--set`; `own` names a law that the caller computes.
    #[new]
    #[pyo3(signature = (name, set=Vec::new(), controller=None, seed=None, duration=None, own=None))]
    fn new(
        name: &str,
        set: Vec<String>,
        controller: Option<String>,
        seed: Option<String>,
        duration: Option<String>,
        own: Option<String>,
    ) -> PyResult<Self> {
        let of_key = |text: &str| Setting::read("set:", text);
        let set = set.iter().map(|text| of_key(text)).collect::<Result<_, _>>();
        let value = |option, text: Option<String>| {
            text.map(|text| option_value(option, &text)).transpose().map_err(refuse)
        };
        let own = own.map(|name| NamedLaw { name, source: LawSource::Caller });
        let options = ScenarioOptions {
            controller,
            seed: value("seed:", seed)?,
            duration: value("duration_s:", duration)?,
            set: set.map_err(refuse)?,
            laws: LawOptions { laws: own.into_iter().collect() },
            are_from_python: true,
            ..ScenarioOptions::default()
        };
        supervise::open(name, &options).map(Self).map_err(|error| raise(&error))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name.as_str()
    }

    /// Name of its law.
    #[getter]
    fn controller(&self) -> &str {
        self.0.controller.name.as_str()
    }

    /// Length, s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.0.duration_s.value()
    }

    /// Smallest and largest request of a law, m/s².
    #[getter]
    fn request_bounds_mps2(&self) -> (f64, f64) {
        let controller = &self.0.controller;
        (controller.min_request_mps2.value(), controller.max_request_mps2.value())
    }

    /// The same with another seed.
    fn with_seed(&self, seed: i64) -> PyResult<Self> {
        let seed =
            Seed::try_from(seed).map_err(|error| ScenarioError::new_err(error.to_string()))?;
        Ok(Self(scenario::Scenario { seed, ..self.0.clone() }))
    }

    /// Remarks on keys without effect.
    #[getter]
    fn notices(&self) -> Vec<String> {
        self.0.notices().map(str::to_owned).collect()
    }

    /// The scenario as it takes effect.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }
}
