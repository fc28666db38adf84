//! `timegap.mpc`: the solver of the predictive laws, built once and solved each cycle.
//!
//! Vectors cross the border as bytes of 64-bit floats, and `timegap/mpc.py` converts numpy arrays to them and back. The
//! stable interface of Python 3.9 has no buffers.

use mpc_solver::{
    LightCost, LightStage, Problem, ProblemError, Report, Riccati, Row, Softness, Solver, Start,
    Status,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// A row as Python says it: gradient, first and last stage, limit, linear and quadratic penalty of a soft one.
type RowArgument = ([f64; 3], usize, usize, f64, Option<(f64, f64)>);
/// A barrier as Python says it: weight, threshold, penalty of a soft one.
type LightArgument = (f64, f64, Option<f64>);

/// A problem with its solver.
#[pyclass(module = "timegap._timegap")]
pub struct Mpc {
    problem: Problem,
    /// It is on Rust's heap: its vectors are aligned to 32 bytes, and Python aligns its objects to 16.
    solver: Box<Riccati>,
    last: Option<Report>,
}

#[pymethods]
impl Mpc {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "Python names them; mpc.py documents them")]
    fn new(
        horizon: usize,
        a: [[f64; 3]; 3],
        b: [f64; 3],
        q: [[f64; 3]; 3],
        s: [f64; 3],
        r: f64,
        p: [[f64; 3]; 3],
        bounds: (f64, f64),
        rows: Vec<RowArgument>,
        terminal: Option<[f64; 3]>,
        light: Option<LightArgument>,
    ) -> PyResult<Self> {
        let mut builder = Problem::builder(horizon)
            .dynamics(a, b)
            .state_cost(q)
            .cross_cost(s)
            .input_cost(r)
            .terminal_cost(p)
            .input_bounds(bounds.0, bounds.1);
        for (gradient, from, to, limit, soft) in rows {
            let softness = soft
                .map_or(Softness::Hard, |(linear, quadratic)| Softness::Soft { linear, quadratic });
            builder = builder.row(Row { gradient, from, to, limit, softness });
        }
        if let Some(x_f) = terminal {
            builder = builder.terminal_equality(x_f);
        }
        if let Some((weight, threshold, soft)) = light {
            let softness =
                soft.map_or(Softness::Hard, |linear| Softness::Soft { linear, quadratic: 0.0 });
            builder = builder.light(LightCost { weight, threshold, softness });
        }
        let refused = |error: ProblemError| PyValueError::new_err(error.to_string());
        let problem = builder.build().map_err(refused)?;
        let solver = Box::new(Riccati::new(problem.horizon()));
        Ok(Self { problem, solver, last: None })
    }

    /// Sets `x_f` of a problem that ends there.
    fn set_target(&mut self, target: [f64; 3]) {
        self.problem.set_terminal_target(target);
    }

    /// Sets `p`.
    fn set_terminal_gradient(&mut self, gradient: [f64; 3]) {
        self.problem.set_terminal_gradient(gradient);
    }

    /// Sets `d_k`: N rows of three numbers.
    fn set_disturbances(&mut self, bytes: &[u8]) -> PyResult<()> {
        fill(self.problem.disturbances_mut().as_flattened_mut(), bytes, "disturbances")
    }

    /// Sets `q_k`: N rows of three numbers.
    fn set_state_gradients(&mut self, bytes: &[u8]) -> PyResult<()> {
        fill(self.problem.state_gradients_mut().as_flattened_mut(), bytes, "state_gradients")
    }

    /// Sets `ρ_k`: N numbers.
    fn set_input_gradients(&mut self, bytes: &[u8]) -> PyResult<()> {
        fill(self.problem.input_gradients_mut(), bytes, "input_gradients")
    }

    /// Sets `h_{row,k}`: N + 1 numbers.
    fn set_row_limits(&mut self, row: usize, bytes: &[u8]) -> PyResult<()> {
        if row >= self.problem.rows().len() {
            let rows = self.problem.rows().len();
            let said = format!("row {row} of {rows}, expected a row of the problem");
            return Err(PyValueError::new_err(said));
        }
        fill(self.problem.row_limits_mut(row), bytes, "limits")
    }

    /// Sets the margins of stages 1 to K: rows of gradient and offset.
    fn set_light(&mut self, bytes: &[u8]) -> PyResult<()> {
        let stages = bytes.len() / 32;
        let mut numbers = vec![0.0; 4 * stages];
        fill(&mut numbers, bytes, "light")?;
        self.problem.set_light(numbers.chunks_exact(4).map(|stage| LightStage {
            gradient: [stage[0], stage[1], stage[2]],
            offset: stage[3],
        }));
        Ok(())
    }

    /// Solves from `x0`, cold or from the last solution moved by `shift` steps. Returns the status, the inputs and
    /// the states.
    fn solve<'py>(
        &mut self,
        py: Python<'py>,
        x0: [f64; 3],
        shift: Option<usize>,
    ) -> (&'static str, Bound<'py, PyBytes>, Bound<'py, PyBytes>) {
        self.problem.set_initial_state(x0);
        let start = shift.map_or(Start::Cold, Start::Shifted);
        let report = py.detach(|| self.solver.solve(&self.problem, start));
        self.last = Some(report);
        let status = match report.status {
            Status::Solved => "solved",
            Status::IterationLimit => "iteration limit",
            Status::Infeasible => "infeasible",
            Status::InvalidInput => "invalid input",
        };
        let inputs = PyBytes::new(py, &bytes(self.solver.inputs()));
        let states = PyBytes::new(py, &bytes(self.solver.states().as_flattened()));
        (status, inputs, states)
    }

    /// Iterations, objective and the residuals of stationarity, complementarity and feasibility of the last solve.
    fn report(&self) -> Option<(u32, f64, f64, f64, f64)> {
        self.last.map(|report| {
            let residuals = report.residuals;
            let of = (residuals.stationarity, residuals.complementarity, residuals.feasibility);
            let cost = self.problem.objective(self.solver.inputs(), self.solver.states());
            (report.iterations, cost, of.0, of.1, of.2)
        })
    }
}

/// Takes numbers out of their bytes.
fn fill(numbers: &mut [f64], bytes: &[u8], name: &str) -> PyResult<()> {
    if bytes.len() != 8 * numbers.len() {
        let (found, expected) = (bytes.len() / 8, numbers.len());
        let said = format!("{name} with {found} numbers, expected {expected}");
        return Err(PyValueError::new_err(said));
    }
    for (number, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(8)) {
        *number = f64::from_ne_bytes(bytes.try_into().expect("eight bytes"));
    }
    Ok(())
}

fn bytes(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_ne_bytes()).collect()
}
