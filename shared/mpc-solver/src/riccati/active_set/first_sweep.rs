//! Backward sweep of the first round, cached from solve to solve.
//!
//! In a cold first round all inputs are free and the light is absent. In a warm one this often
//! holds from some stage on. Without linear terms, the sweep down to that stage depends on the
//! matrices alone: it is the unconstrained regulator's sweep. A controller that solves the same
//! program in every cycle, with other states and another light, need not repeat it.
//!
//! The cache holds exactly the numbers that a new computation gives, so a result does not depend on
//! earlier solves.

use crate::problem::{Problem, Terminal};
use crate::riccati::lqr::{BlockModels, Cost, CostToGo, LinearQuadratic, Sweep, Unconstrained};

/// The sweep, and the matrices it was computed from.
#[derive(Clone, Debug)]
pub(super) struct FirstSweep {
    made_from: Option<(LinearQuadratic, usize, bool)>,
    sweep: Sweep,
    cost_to_go: CostToGo,
}

impl FirstSweep {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self { made_from: None, sweep: Sweep::new(max_horizon), cost_to_go: CostToGo::default() }
    }

    /// Fills `sweep` for the first round of an attempt, which holds inputs and places tangents only
    /// up to stage `last`.
    pub(super) fn fill<M: BlockModels>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost: &Cost,
        models: &mut M,
        last: usize,
        sweep: &mut Sweep,
    ) -> CostToGo {
        let n = problem.horizon;
        if lq.has_linear_terms || last == n {
            return lq.factor(problem, models, sweep, n);
        }
        let is_fixed = matches!(problem.terminal, Terminal::Equality(_));
        let made_from = Some((*lq, n, is_fixed));
        if self.made_from != made_from {
            self.cost_to_go = lq.factor(problem, &mut Unconstrained(cost), &mut self.sweep, n);
            self.made_from = made_from;
        }
        sweep.copy_from(&self.sweep, n);
        if last == 0 { self.cost_to_go } else { lq.factor(problem, models, sweep, last) }
    }
}
