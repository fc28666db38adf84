//! Backward sweep of the first round, cached from solve to solve.
//!
//! In a cold first round all inputs are free and the light is absent. Without linear terms, the sweep depends on the
//! matrices alone: it is the unconstrained regulator's sweep. A controller that solves the same program in every cycle,
//! with other states and another light, need not repeat it.
//!
//! The cache holds exactly the numbers that a new computation gives, so a result does not depend on
//! earlier solves.

use crate::problem::Problem;
use crate::riccati::lqr::{Cost, CostToGo, LinearQuadratic, Sweep, Unconstrained};

/// The sweep, and the build of the problem that it was computed from.
#[derive(Clone, Debug)]
pub(super) struct FirstSweep {
    made_from: Option<u64>,
    sweep: Sweep,
    cost_to_go: CostToGo,
}

impl FirstSweep {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self { made_from: None, sweep: Sweep::new(max_horizon), cost_to_go: CostToGo::default() }
    }

    /// Fills `sweep` for free inputs.
    pub(super) fn fill(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost: &Cost,
        sweep: &mut Sweep,
    ) -> CostToGo {
        let n = problem.horizon;
        if lq.has_linear_terms {
            return lq.factor(problem, &mut Unconstrained(cost), sweep, n);
        }
        if self.made_from != Some(problem.build) {
            self.cost_to_go = lq.factor(problem, &mut Unconstrained(cost), &mut self.sweep, n);
            self.made_from = Some(problem.build);
        }
        sweep.copy_from(&self.sweep, n);
        self.cost_to_go
    }
}
