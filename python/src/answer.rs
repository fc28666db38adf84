//! The answers of a law: a number, or an `Answer`.

use bytemuck::Zeroable;
use messages::{LAW_FIGURES, LAW_MODES, LAW_PLAN, LawAnswer};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyString};

/// An answer with more than a request.
#[pyclass(frozen, module = "timegap._timegap", skip_from_py_object)]
#[derive(Clone)]
pub struct Answer(LawAnswer);

/// Copies `values` to the start of `into`, or says what is wrong.
fn copy(name: &str, values: &[f64], into: &mut [f64]) -> PyResult<()> {
    let most = into.len();
    let Some(place) = into.get_mut(..values.len()) else {
        let count = values.len();
        return Err(PyValueError::new_err(format!(
            "{name}: {count} values, expected at most {most}"
        )));
    };
    place.copy_from_slice(values);
    Ok(())
}

#[pymethods]
impl Answer {
    /// Makes an answer.
    #[new]
    #[pyo3(signature = (request_mps2, *, plan_mps2=None, mode=0, figures=None, engine_torque_nm=None, service_brake_n=0.0, gear=0))]
    fn new(
        request_mps2: f64,
        plan_mps2: Option<Vec<f64>>,
        mode: u64,
        figures: Option<Vec<f64>>,
        engine_torque_nm: Option<f64>,
        service_brake_n: f64,
        gear: u64,
    ) -> PyResult<Self> {
        let mut answer = LawAnswer { request_mps2, mode, gear, ..LawAnswer::zeroed() };
        if mode >= LAW_MODES as u64 {
            let most = LAW_MODES - 1;
            return Err(PyValueError::new_err(format!("mode = {mode}, expected at most {most}")));
        }
        let plan = plan_mps2.unwrap_or_default();
        debug_assert!(answer.plan_mps2.len() == LAW_PLAN && answer.figures.len() == LAW_FIGURES);
        copy("plan_mps2", &plan, &mut answer.plan_mps2)?;
        answer.plan_count = plan.len() as u64;
        copy("figures", &figures.unwrap_or_default(), &mut answer.figures)?;
        if let Some(torque_nm) = engine_torque_nm {
            answer.has_torque = 1;
            answer.engine_torque_nm = torque_nm;
            answer.service_brake_n = service_brake_n;
        }
        Ok(Self(answer))
    }

    /// The request that acts now, m/s².
    #[getter]
    fn request_mps2(&self) -> f64 {
        self.0.request_mps2
    }

    fn __repr__(&self) -> String {
        format!("Answer(request_mps2={})", self.0.request_mps2)
    }
}

/// The answer of the law `name` as a record.
pub fn of(returned: &Bound<'_, PyAny>, name: &str) -> PyResult<LawAnswer> {
    if let Ok(number) = returned.cast_exact::<PyFloat>() {
        return Ok(LawAnswer { request_mps2: number.extract()?, ..LawAnswer::zeroed() });
    }
    if let Ok(answer) = returned.cast::<Answer>() {
        return Ok(answer.get().0);
    }
    let expected = "expected a number in m/s², or timegap.Answer";
    let refuse = |what: String| {
        Err(PyTypeError::new_err(format!("the law `{name}` returned {what}, {expected}")))
    };
    if returned.is_none() {
        return refuse("None".to_owned());
    }
    if returned.is_instance_of::<PyString>() || returned.is_instance_of::<PyBool>() {
        return refuse(returned.repr()?.to_string());
    }
    if let Ok(shape) = returned.getattr("shape")
        && shape.len().is_ok_and(|dimensions| dimensions > 0)
    {
        return refuse(format!("an array of shape {}", shape.repr()?));
    }
    let is_number = returned.is_instance_of::<PyInt>() || returned.hasattr("__float__")?;
    match returned.extract::<f64>() {
        Ok(request_mps2) if is_number => Ok(LawAnswer { request_mps2, ..LawAnswer::zeroed() }),
        _ => refuse(format!("a value of type {}", returned.get_type().name()?)),
    }
}
