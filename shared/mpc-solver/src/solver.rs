//! Interface of the solvers.

use crate::kkt::{Multipliers, Residuals};
use crate::problem::Problem;

/// Starting point of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// The problem alone: the result does not depend on any earlier solve.
    #[default]
    Cold,
    /// The previous solution, moved forward by this number of steps (0: the same instant). A solver
    /// without a previous solution for this horizon starts cold, and so does [`crate::Riccati`] above
    /// 40 steps, with the light, and with a fixed end.
    Shifted(usize),
}

/// Outcome of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The optimality conditions hold to the solver's tolerance.
    Solved,
    /// The optimality conditions do not hold after the last permitted iteration, or at the end of
    /// the machine's precision. The inputs are the best known ones and within their bounds.
    IterationLimit,
    /// No input satisfies the hard constraints: a certificate was found and checked. The inputs are
    /// within their bounds and come from the attempt.
    Infeasible,
    /// The problem holds a number that is not finite, exceeds the solver's capacity, or overflows.
    /// The inputs are zero, or the bound nearest to it.
    InvalidInput,
}

/// Result of one solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Outcome.
    pub status: Status,
    /// Number of iterations: factorisations of the whole horizon or of a part of it.
    pub iterations: u32,
    /// Number of these iterations that an interior point made; the others are rounds of an active
    /// set.
    pub interior_iterations: u32,
    /// Scaled residuals of the optimality conditions at the returned point.
    pub residuals: Residuals,
}

/// Solver of [`Problem`]; it keeps its work memory and its last solution.
///
/// ```
/// use mpc_solver::{Problem, ProblemError, Solver, Start, Status};
///
/// /// Returns the first input of the plan, or `None` where the problem has no solution.
/// fn first_input(solver: &mut dyn Solver, problem: &Problem) -> Option<f64> {
///     let report = solver.solve(problem, Start::Shifted(1));
///     (report.status == Status::Solved).then(|| solver.inputs()[0])
/// }
///
/// let problem = Problem::builder(30)
///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
///     .input_bounds(-4.9, 4.9)
///     .input_cost(1.0)
///     .build()?;
/// assert_eq!(first_input(&mut mpc_solver::Riccati::new(30), &problem), Some(0.0));
/// # Ok::<(), ProblemError>(())
/// ```
pub trait Solver {
    /// Solves the problem. It never panics, ends after a bounded number of iterations, and always
    /// leaves usable inputs.
    fn solve(&mut self, problem: &Problem, start: Start) -> Report;

    /// Returns `u_0 … u_{N-1}` of the last solve, within their bounds for every status.
    fn inputs(&self) -> &[f64];

    /// Returns `x_0 … x_N`, which follow from the inputs.
    fn states(&self) -> &[[f64; 3]];

    /// Returns the multipliers of the last solve.
    fn multipliers(&self) -> &Multipliers;
}
