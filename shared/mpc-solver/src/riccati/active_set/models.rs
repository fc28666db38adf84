//! The guess of the active set as models of the stages, for the backward sweep.

use crate::problem::{LightStage, Problem};
use crate::riccati::lanes::Vector;
use crate::riccati::light_curve::LightTangent;
use crate::riccati::lqr::{InputModel, StageModels};
use crate::riccati::matrix::{Rows, add_slope};
use crate::riccati::row_curve::RowTangent;
use crate::riccati::working_set::Side;

/// The guess as models of the stages.
pub(super) struct Models<'a> {
    pub(super) problem: &'a Problem,
    pub(super) sides: &'a [Side],
    pub(super) tangents: &'a [LightTangent],
    pub(super) stages: &'a [LightStage],
    pub(super) rows: &'a [Vec<RowTangent>],
}

impl Models<'_> {
    /// Returns the last stage with a held input or a tangent; `n` with row tangents.
    pub(super) fn last_modelled(&self, n: usize) -> usize {
        if !self.rows.is_empty() {
            return n;
        }
        let held = self.sides[..n].iter().rposition(|side| *side as i8 != Side::Free as i8);
        held.map_or(0, |k| k + 1).max(self.stages.len()).min(n)
    }
}

impl StageModels for Models<'_> {
    #[inline(always)]
    fn input(&self, k: usize) -> InputModel {
        let gradient = self.problem.r_lin[k];
        match self.sides[k] {
            Side::Free => InputModel::Free(0.0, gradient),
            Side::Upper => InputModel::Held(self.problem.u_max, gradient),
            Side::Lower => InputModel::Held(self.problem.u_min, gradient),
        }
    }

    #[inline(always)]
    fn state<V: Vector>(&self, k: usize, hessian: &mut Rows<V>) -> [f64; 3] {
        let problem = self.problem;
        let mut gradient = if k < problem.horizon { problem.q_lin[k] } else { problem.p_lin };
        if k == 0 {
            return gradient;
        }
        if k <= self.stages.len() {
            let (stage, tangent) = (&self.stages[k - 1], &self.tangents[k - 1]);
            let [c0, c1, c2] = stage.gradient;
            hessian.add_rank_one(V::from_array([c0, c1, c2, stage.offset]), tangent.slope);
            add_slope(&mut gradient, &stage.gradient, -tangent.at_origin(stage.offset));
        }
        for (j, tangents) in self.rows.iter().enumerate() {
            let tangent = &tangents[k];
            if tangent.acts() {
                let g = &problem.rows[j].gradient;
                hessian.add_rank_one(V::from_array([g[0], g[1], g[2], 0.0]), tangent.slope);
                add_slope(&mut gradient, g, tangent.at(-problem.limits[j][k]));
            }
        }
        gradient
    }
}
