//! What every solver takes and returns.

use crate::kkt::{Multipliers, Residuals};
use crate::problem::Problem;

/// Where a solver starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// From the problem alone: the answer does not depend on any earlier solve.
    #[default]
    Cold,
    /// From the previous solution, moved forward by so many steps (0: the same instant). A solver
    /// that has none, or one of another horizon, starts cold.
    Shifted(usize),
}

/// What was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The optimality conditions hold to the solver's tolerance.
    Solved,
    /// They do not yet, after the last permitted iteration or at the end of the machine's precision;
    /// the inputs are the best known and within their bounds.
    IterationLimit,
    /// No input satisfies the hard constraints: a certificate was found and checked. The inputs are
    /// within their bounds and come from the attempt.
    Infeasible,
    /// The problem holds a number that is not finite, exceeds the solver's capacity, or is scaled
    /// such that it cannot be computed with. The inputs are zero, or the bound nearest to it.
    InvalidInput,
}

/// The account of one solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// What was reached.
    pub status: Status,
    /// Iterations: factorisations of the whole horizon or of a part of it.
    pub iterations: u32,
    /// Those of them that were iterations of an interior point; the others were rounds of an active set.
    pub interior_iterations: u32,
    /// Scaled residuals of the optimality conditions at the returned point.
    pub residuals: Residuals,
    /// The objective at the returned point, the cost of the first state included.
    pub objective: f64,
}

/// A solver of [`Problem`]; it keeps its work memory and its last solution.
pub trait Solver {
    /// Solves; never panics, never loops without end, always leaves usable inputs.
    fn solve(&mut self, problem: &Problem, start: Start) -> Report;

    /// `u_0 … u_{N-1}` of the last solve, within their bounds whatever the status.
    fn inputs(&self) -> &[f64];

    /// `x_0 … x_N` that follow from the inputs.
    fn states(&self) -> &[[f64; 3]];

    /// Multipliers of the last solve.
    fn multipliers(&self) -> &Multipliers;
}
