//! The guess of the active set as models of the stages: its tangents in place of the curves of light and rows, renewed in
//! each round, and the sweep of the first round, which has no guess.

use super::{ON_CURVE, Point, RowChange};
use crate::problem::{Problem, dot};
use crate::riccati::curve::{Curve, Tangent};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::{
    BlockModel, BlockModels, Cost, CostToGo, LinearQuadratic, Sweep, Unconstrained,
};
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

/// Backward sweep of the first round, cached from solve to solve, and the build that it was computed from.
///
/// In a cold first round all inputs are free and the light is absent. Without linear terms, the sweep depends on the
/// matrices alone: it is the unconstrained regulator's sweep. A controller that solves the same program in every cycle,
/// with other states and another light, need not repeat it.
///
/// The cache holds exactly the numbers that a new computation gives, so a result does not depend on
/// earlier solves.
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

impl WorkingSet {
    /// Moves the light's tangents to where the last step led, and writes the multipliers there. Returns the largest
    /// relative distance from the curve. `is_first` places tangents at the margins of a trajectory without the light.
    pub(super) fn renew_light(
        &mut self,
        problem: &Problem,
        is_first: bool,
        point: &mut Point,
    ) -> f64 {
        let Some(cost) = problem.light.as_ref().filter(|_| problem.light_len > 0) else {
            return 0.0;
        };
        let curve = Curve::of_light(cost);
        let stages = problem.light_stages().iter().zip(&point.states[1..]);
        let margins = stages.map(|(stage, x)| dot(&stage.gradient, x) + stage.offset);
        let tangents = self.light[1..].iter_mut().zip(margins.clone());
        if is_first {
            let best = margins.fold(f64::NEG_INFINITY, f64::max);
            tangents.for_each(|(tangent, margin)| *tangent = curve.start(margin, best));
            return f64::INFINITY;
        }
        let mut worst: f64 = 0.0;
        for ((tangent, margin), alpha) in tangents.zip(&mut point.multipliers.light[1..]) {
            let (next, reached, distance) = curve.project(tangent, margin);
            (*tangent, *alpha) = (next, reached);
            worst = worst.max(distance);
        }
        worst
    }

    /// Renews the rows' tangents, and writes the multipliers there.
    pub(super) fn renew_rows(&mut self, problem: &Problem, point: &mut Point) -> RowChange {
        let mut change = RowChange::by_working_set(true);
        for (j, row) in problem.rows.iter().enumerate() {
            for k in row.from..=row.to {
                let h = problem.limits[j][k];
                let (tangent, mu) = (&mut self.rows[j][k], &mut point.multipliers.rows[j][k]);
                let margin = h - dot(&row.gradient, &point.states[k]);
                if h == f64::INFINITY || (margin >= 0.0 && !tangent.acts()) {
                    *mu = 0.0;
                    continue;
                }
                let curve = Curve::of_row(row.softness, h, self.row_stiffness);
                let (next, reached, distance) = curve.project(tangent, margin);
                (*tangent, *mu) = (next, reached);
                change.is_complete &= distance <= ON_CURVE;
                change.parts += usize::from(distance >= 1.0);
                change.last_stage = change.last_stage.max(k);
            }
        }
        change
    }
}
