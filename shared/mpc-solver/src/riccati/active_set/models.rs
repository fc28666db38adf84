//! The guess of the active set as models of the stages, for the backward sweep.

use crate::problem::{LightStage, Problem};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::light_curve::LightTangent;
use crate::riccati::lqr::{BlockModel, BlockModels, Cost};
use crate::riccati::row_curve::RowTangent;
use crate::riccati::working_set::Side;

/// The guess as models of the stages.
pub(super) struct Models<'a> {
    pub(super) problem: &'a Problem,
    pub(super) cost: &'a Cost,
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

impl BlockModels for Models<'_> {
    const IS_WHOLE: bool = true;

    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        let (problem, lit) = (self.problem, self.stages.len());
        let mut model = self.cost.block(j);
        let stages = WIDTH * j..(WIDTH * (j + 1)).min(problem.horizon + 1);
        if lit > 0 && stages.start <= lit {
            let (mut g, [mut curvature, mut slope]) = ([Lanes::default(); 3], Default::default());
            for k in stages.start.max(1)..stages.end.min(lit + 1) {
                let (stage, tangent) = (&self.stages[k - 1], &self.tangents[k - 1]);
                let alpha = tangent.at_origin(stage.offset);
                set(
                    k % WIDTH,
                    (&mut g, &stage.gradient),
                    [(&mut curvature, tangent.slope), (&mut slope, -alpha)],
                );
            }
            model.add(&g, curvature, slope);
        }
        for (j, tangents) in self.rows.iter().enumerate() {
            if !tangents[stages.clone()].iter().any(RowTangent::acts) {
                continue;
            }
            let (mut g, [mut curvature, mut slope]) = ([Lanes::default(); 3], Default::default());
            for k in stages.clone().filter(|k| *k > 0 && tangents[*k].acts()) {
                let force = tangents[k].at(-problem.limits[j][k]);
                set(
                    k % WIDTH,
                    (&mut g, &problem.rows[j].gradient),
                    [(&mut curvature, tangents[k].slope), (&mut slope, force)],
                );
            }
            model.add(&g, curvature, slope);
        }
        model
    }

    #[inline(always)]
    fn held(&self, k: usize) -> Option<f64> {
        match self.sides[k] {
            Side::Free => None,
            Side::Upper => Some(self.problem.u_max),
            Side::Lower => Some(self.problem.u_min),
        }
    }
}

/// Sets one lane of a function of `g'x`: its gradient, its curvature and its slope.
#[inline(always)]
fn set(lane: usize, (to, gradient): (&mut [Lanes; 3], &[f64; 3]), numbers: [(&mut Lanes, f64); 2]) {
    for (lanes, g) in to.iter_mut().zip(gradient) {
        lanes.0[lane] = *g;
    }
    for (lanes, number) in numbers {
        lanes.0[lane] = number;
    }
}
