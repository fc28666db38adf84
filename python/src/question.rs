//! A law's question at one release: fields, and views of the arrays.

use messages::{LAW_INTERVALS, LawInput, LawInterval, LawSignal};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// A question to a law. Arrays are views of it: nothing is copied before a law asks for it.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct Question(LawInput);

impl Question {
    pub fn new(question: LawInput) -> Self {
        Self(question)
    }
}

/// A part of a question's bytes, for numpy's array interface. It owns the question.
#[pyclass(frozen, module = "timegap._timegap")]
struct Part {
    _question: Py<Question>,
    address: usize,
    count: usize,
    is_signals: bool,
}

#[pymethods]
impl Part {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", (self.count,))?;
        // The second one: it cannot be written.
        interface.set_item("data", (self.address, true))?;
        if self.is_signals {
            let phase = [("phase", "<u8"), ("ends_in_s", "<f8")];
            let descr = PyList::empty(py);
            descr.append(("id", "<u8"))?;
            descr.append(("distance_m", "<f8"))?;
            descr.append(("interval_count", "<u8"))?;
            descr.append(("intervals", PyList::new(py, phase)?, (LAW_INTERVALS,)))?;
            interface.set_item("typestr", format!("|V{}", size_of::<LawSignal>()))?;
            interface.set_item("descr", descr)?;
        } else {
            interface.set_item("typestr", "<f8")?;
        }
        Ok(interface)
    }
}

const _: () = assert!(size_of::<LawSignal>() == 24 + LAW_INTERVALS * size_of::<LawInterval>());

/// The first `count` elements of a question's array, as numpy sees them.
fn view<'py>(
    question: &Bound<'py, Question>,
    address: usize,
    count: u64,
    is_signals: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let py = question.py();
    let count = usize::try_from(count).unwrap_or_default();
    let part = Part { _question: question.clone().unbind(), address, count, is_signals };
    py.import("numpy")?.call_method1("asarray", (part,))
}

/// Getters of plain fields.
macro_rules! fields {
    ($($(#[$doc:meta])* $name:ident: $type:ty = |$q:ident| $value:expr;)+) => {
        #[pymethods]
        impl Question {
            $($(#[$doc])*
            #[getter]
            fn $name(&self) -> $type {
                let $q = &self.0;
                $value
            })+

            /// Signals ahead, nearest first: a structured array with `id`, `distance_m`, `interval_count`, `intervals`.
            #[getter]
            fn signals<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
                let q = &slf.get().0;
                view(slf, q.signals.as_ptr() as usize, q.signal_count, true)
            }

            /// Mean grade of each cell of the road ahead, rise over run.
            #[getter]
            fn cell_grades<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
                let q = &slf.get().0;
                view(slf, q.cell_grades.as_ptr() as usize, q.cell_count, false)
            }

            /// Seven figures, as numpy takes them at once: speed, acceleration, set speed, 1 with a target, gap, and
            /// relative speed and acceleration of the target. `farthest_m` is the gap without a target.
            fn observation(&self, farthest_m: f64) -> (f64, f64, f64, f64, f64, f64, f64) {
                let q = &self.0;
                let has_target = q.has_target == 1;
                (
                    q.speed_mps,
                    q.acceleration_mps2,
                    q.set_speed_mps,
                    f64::from(u8::from(has_target)),
                    if has_target { q.gap_m } else { farthest_m },
                    q.relative_speed_mps,
                    q.target_acceleration_mps2,
                )
            }

            fn __repr__(&self) -> String {
                let q = &self.0;
                let target = match q.has_target {
                    1 => format!(", gap_m={}, relative_speed_mps={}", q.gap_m, q.relative_speed_mps),
                    _ => String::new(),
                };
                format!("Question(time_s={}, speed_mps={}{target})", q.time_s, q.speed_mps)
            }
        }
    };
}

fields! {
    /// Time of the release since the start of the run, s.
    time_s: f64 = |q| q.time_s;
    /// Control period, s.
    period_s: f64 = |q| q.period_s;
    /// The law must clear its history before it answers.
    is_reset: bool = |q| q.reset == 1;
    /// Distance travelled since the start of the run, m.
    position_m: f64 = |q| q.position_m;
    /// Speed, m/s, never negative.
    speed_mps: f64 = |q| q.speed_mps;
    /// Acceleration, m/s².
    acceleration_mps2: f64 = |q| q.acceleration_mps2;
    /// Driver's set speed, m/s.
    set_speed_mps: f64 = |q| q.set_speed_mps;
    /// Legal limit on this road, m/s; infinite when unknown.
    speed_limit_mps: f64 = |q| q.speed_limit_mps;
    /// There is a vehicle ahead.
    has_target: bool = |q| q.has_target == 1;
    /// Identity of the target; 0 without one. A new number means a new vehicle.
    target_id: u64 = |q| q.target_id;
    /// Bumper-to-bumper distance to the target, m; infinite without one.
    gap_m: f64 = |q| if q.has_target == 1 { q.gap_m } else { f64::INFINITY };
    /// Target speed minus ego speed, m/s, negative when closing; 0 without a target.
    relative_speed_mps: f64 = |q| q.relative_speed_mps;
    /// Absolute acceleration of the target, m/s²; 0 without one.
    target_acceleration_mps2: f64 = |q| q.target_acceleration_mps2;
    /// Age of the sample behind the target, s.
    target_age_s: f64 = |q| q.target_age_s;
    /// The vehicle is a truck; the next four fields are 0 otherwise.
    has_powertrain: bool = |q| q.has_powertrain == 1;
    /// Gear, counted from 1; the one being engaged during a shift.
    gear: u64 = |q| q.gear;
    /// Time since the last shift began, s.
    since_shift_s: f64 = |q| q.since_shift_s;
    /// Torque at the crankshaft, N m.
    engine_torque_nm: f64 = |q| q.engine_torque_nm;
    /// The vehicle's own estimate of the grade under it, rise over run.
    grade: f64 = |q| q.grade;
    /// Start of the first cell of the road ahead, m, as `position_m`.
    first_cell_m: f64 = |q| q.first_cell_m;
    /// Length of a cell of the road ahead, m.
    cell_m: f64 = |q| q.cell_m;
}
