//! The guess of the active set as models of the stages, for the backward sweep.

use crate::problem::Problem;
use crate::riccati::curve::Tangent;
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::{BlockModel, BlockModels, Cost};
use crate::riccati::working_set::{Side, WorkingSet};

/// The guess as models of the stages.
pub(super) struct Models<'a> {
    pub(super) problem: &'a Problem,
    pub(super) cost: &'a Cost,
    pub(super) guess: &'a WorkingSet,
    /// Number of rows that the guess holds by their tangents.
    pub(super) rows: usize,
}

impl BlockModels for Models<'_> {
    const IS_WHOLE: bool = true;

    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        let (problem, guess) = (self.problem, self.guess);
        let mut model = self.cost.block(j);
        let first = WIDTH * j;
        if first <= problem.light_len && problem.light_len > 0 {
            add(&mut model, &guess.light, first, problem.light_len, -1.0, |k| {
                let stage = &problem.light_stages[k - 1];
                (&stage.gradient, stage.offset)
            });
        }
        for (j, tangents) in guess.rows[..self.rows].iter().enumerate() {
            if tangents[first..].iter().take(WIDTH).any(Tangent::acts) {
                let row = &problem.rows[j].gradient;
                add(&mut model, tangents, first, problem.horizon, 1.0, |k| {
                    (row, problem.limits[j][k])
                });
            }
        }
        model
    }

    #[inline(always)]
    fn held(&self, k: usize) -> Option<f64> {
        match self.guess.sides[k] {
            Side::Free => None,
            Side::Upper => Some(self.problem.u_max),
            Side::Lower => Some(self.problem.u_min),
        }
    }
}

/// Adds the tangents of a block up to stage `last`. `of` returns a stage's gradient and the margin of the zero state;
/// `sign` is that of the force along the gradient.
#[inline(always)]
fn add<'a>(
    model: &mut BlockModel,
    tangents: &[Tangent],
    first: usize,
    last: usize,
    sign: f64,
    of: impl Fn(usize) -> (&'a [f64; 3], f64),
) {
    let (mut g, [mut curvature, mut slope]) = ([Lanes::default(); 3], Default::default());
    let (curvatures, slopes): (&mut Lanes, &mut Lanes) = (&mut curvature, &mut slope);
    for k in (first.max(1)..=last).take_while(|k| *k < first + WIDTH) {
        let tangent = &tangents[k];
        if tangent.acts() {
            let (gradient, offset) = of(k);
            let lane = k % WIDTH;
            for (lanes, g) in g.iter_mut().zip(gradient) {
                lanes.0[lane] = *g;
            }
            curvatures.0[lane] = tangent.slope;
            slopes.0[lane] = sign * tangent.at_origin(offset);
        }
    }
    model.add(&g, curvature, slope);
}
