//! timegap as a Python package: runs in this process, with a Python function as the law.
//!
//! ```text
//! timegap/*.py ── types, tables, plots, Gymnasium
//!      │
//!  _timegap ───── scenario ─► run ─► advance … question ─► law(q) ─► answer … ─► results
//! ```
//!
//! The law runs between two turns of the services, in the interpreter's own thread and on its own stack. The global
//! interpreter lock is held inside the law alone, so that threads drive at once.

#![cfg(feature = "module")]

mod answer;
mod compare;
mod errors;
mod law;
mod mpc;
mod question;
mod recording;
mod registry;
mod run;
mod scenario;
mod stepper;
mod string;

use pyo3::prelude::*;

#[pymodule]
fn _timegap(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("ScenarioError", module.py().get_type::<errors::ScenarioError>())?;
    module.add("RunError", module.py().get_type::<errors::RunError>())?;
    module.add_class::<answer::Answer>()?;
    module.add_class::<mpc::Mpc>()?;
    module.add_class::<question::Question>()?;
    module.add_class::<recording::Recording>()?;
    module.add_class::<run::Driven>()?;
    module.add_class::<scenario::Scenario>()?;
    module.add_class::<stepper::Stepper>()?;
    module.add_class::<string::CarString>()?;
    module.add_function(wrap_pyfunction!(run::drive, module)?)?;
    module.add_function(wrap_pyfunction!(run::interrupt_runs, module)?)?;
    module.add_function(wrap_pyfunction!(run::interrupts, module)?)?;
    module.add_function(wrap_pyfunction!(run::work_since, module)?)?;
    module.add_function(wrap_pyfunction!(compare::over_seeds, module)?)?;
    module.add_function(wrap_pyfunction!(registry::figures, module)?)?;
    module.add_function(wrap_pyfunction!(registry::figures_of, module)?)?;
    module.add_function(wrap_pyfunction!(registry::scenarios, module)?)?;
    module.add_function(wrap_pyfunction!(registry::laws, module)?)
}
