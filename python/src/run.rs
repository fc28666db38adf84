//! A run, driven to its end, and its results.

use crate::errors::raise;
use crate::law::{Law, Raised};
use crate::scenario::Scenario;
use controller::law::Formulation;
use controller::laws::external::Questions;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use report::summary::Summary;
use report::trajectory;
use runtime::{Mode, Sealing};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use supervise::GroupOutcome;
use supervise::in_process::{Advance, SteppedRun};

/// Turns of the services between two looks for signals.
const TURNS: u32 = 512;

/// Times that all runs of this process were interrupted. Python gives signals to its main thread alone, and the others
/// look here.
static INTERRUPTS: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// Number of interrupts before the work of this thread, if it belongs to a caller in another one.
    static BEFORE: Cell<Option<u64>> = const { Cell::new(None) };
}

/// Ends the runs that go on in other threads, with a KeyboardInterrupt.
#[pyfunction]
pub fn interrupt_runs() {
    INTERRUPTS.fetch_add(1, Ordering::Relaxed);
}

/// Number of interrupts so far.
#[pyfunction]
pub fn interrupts() -> u64 {
    INTERRUPTS.load(Ordering::Relaxed)
}

/// Makes the runs of this thread part of work that began after so many interrupts.
#[pyfunction]
pub fn work_since(interrupts: u64) {
    BEFORE.set(Some(interrupts));
}

/// The result of a run.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct Driven {
    pub summary: Summary,
    pub drive: supervise::Drive,
    figures: Vec<&'static str>,
    modes: Vec<&'static str>,
    exception: Option<Py<PyAny>>,
}

impl Driven {
    /// The result of a run that is over.
    pub fn of(
        scenario: &scenario::Scenario,
        outcome: GroupOutcome,
        begun: Instant,
        exception: Option<Py<PyAny>>,
    ) -> Self {
        let summary = Summary::new(scenario, Mode::Lockstep, &outcome, begun.elapsed());
        let formulation = outcome.formulation(scenario);
        Self {
            summary,
            figures: formulation.map_or_else(Vec::new, Formulation::figure_names),
            modes: formulation.map_or_else(Vec::new, |formulation| formulation.modes.to_vec()),
            drive: outcome.drive,
            exception,
        }
    }
}

#[pymethods]
impl Driven {
    /// `summary.json`.
    fn summary(&self) -> String {
        serde_json::to_string(&self.summary).expect("a summary is plain data")
    }

    /// The columns of `trajectory.csv`: name, and the values as 8-byte floats, NaN where there is none.
    fn trajectory<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyBytes>)> {
        let columns = trajectory::columns(&self.drive, &self.figures);
        let bytes = |values: Vec<Option<f64>>| {
            let values: Vec<f64> =
                values.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
            PyBytes::new(py, bytemuck::cast_slice(&values))
        };
        columns.into_iter().map(|(name, values)| (name, bytes(values))).collect()
    }

    /// Names of the law's modes, in the order of their numbers.
    #[getter]
    fn modes(&self) -> Vec<&'static str> {
        self.modes.clone()
    }

    /// The exception that ended the run, if one did.
    #[getter]
    fn exception(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.exception.as_ref().map(|exception| exception.clone_ref(py))
    }
}

/// End of a drive that did not raise.
struct End {
    outcome: GroupOutcome,
    failed: Option<PyErr>,
}

/// Drives a scenario to its end, by its own law or by `law`.
#[pyfunction]
#[pyo3(signature = (scenario, law=None, digests=false))]
pub fn drive(
    py: Python<'_>,
    scenario: &Scenario,
    law: Option<&Bound<'_, PyAny>>,
    digests: bool,
) -> PyResult<Driven> {
    let scenario = &scenario.0;
    let name = scenario.controller.name.as_str().to_owned();
    let law = law.map(|law| Law::new(law, name)).transpose()?;
    let sealing = if digests { Sealing::Sealed } else { Sealing::Unsealed };
    let begun = Instant::now();
    let end = py.detach(|| to_its_end(scenario, law.as_ref(), sealing))?;
    let exception = end.failed.map(|error| error.into_value(py).into_any());
    Ok(Driven::of(scenario, end.outcome, begun, exception))
}

fn to_its_end(scenario: &scenario::Scenario, law: Option<&Law>, sealing: Sealing) -> PyResult<End> {
    let questions = law.map(|_| Questions::default());
    let begun = SteppedRun::begin(scenario, sealing, questions.clone());
    let mut run = begun.map_err(|error| raise(&error))?;
    let (mut turns, mut failed, mut raised) = (0_u32, None, None);
    let before = BEFORE.get().unwrap_or_else(interrupts);
    loop {
        match run.advance().map_err(|error| raise(&error))? {
            Advance::Turn => {}
            Advance::Over => break,
            Advance::Asked => {
                let (Some(law), Some(questions)) = (law, &questions) else { continue };
                let answered = Python::attach(|py| law.answer(py, questions, &mut failed));
                if let Err(Raised(error)) = answered {
                    raised = Some(error);
                    run.interrupt();
                }
            }
        }
        if raised.is_none() && interrupts() != before {
            raised = Some(PyKeyboardInterrupt::new_err(()));
            run.interrupt();
        }
        turns = turns.wrapping_add(1);
        if turns.is_multiple_of(TURNS)
            && raised.is_none()
            && let Err(error) = Python::attach(|py| py.check_signals())
        {
            raised = Some(error);
            run.interrupt();
        }
    }
    match raised {
        Some(error) => Err(error),
        None => {
            let outcome = run.finish().map_err(|error| raise(&error))?;
            match outcome.ended {
                supervise::Ended::Interrupted => Err(PyKeyboardInterrupt::new_err(())),
                _ => Ok(End { outcome, failed }),
            }
        }
    }
}
