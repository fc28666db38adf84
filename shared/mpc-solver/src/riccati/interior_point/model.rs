//! The iterate as a model of the stages, a block at a time.
//!
//! The backward sweep needs the Hessian and the gradient of each stage. They are those of the cost,
//! and those of each eliminated pair. They are computed lane by lane for a whole block, so the
//! sweep performs only the recursion.

use super::barriers::Barriers;
use super::pairs::{place, product};
use super::path::PathBlock;
use crate::problem::Problem;
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::{BlockModel, BlockModels};

impl BlockModel {
    /// Adds a function of `g'x` by its curvature and its slope.
    #[inline(always)]
    pub(super) fn add(&mut self, g: &[Lanes; 3], curvature: Lanes, slope: Lanes) {
        let wg = [curvature * g[0], curvature * g[1], curvature * g[2]];
        let products =
            [wg[0] * g[0], wg[0] * g[1], wg[0] * g[2], wg[1] * g[1], wg[1] * g[2], wg[2] * g[2]];
        for i in 0..6 {
            self.hessian[i] = self.hessian[i] + products[i];
        }
        for i in 0..3 {
            self.gradient[i] = self.gradient[i] + slope * g[i];
        }
    }
}

/// `Q` and `s`; at the end of the horizon `P` and zero.
#[derive(Clone, Copy, Debug, Default)]
struct QuadraticCost {
    hessian: [Lanes; 6],
    cross: [Lanes; 3],
}

/// `q_k` and `ρ_k`; `p` at the end of the horizon, zero beyond.
#[derive(Clone, Copy, Debug, Default)]
struct LinearCost {
    state: [Lanes; 3],
    input: Lanes,
}

/// Cost in blocks.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    /// Quadratic cost of all blocks but the last, and of the last one.
    quadratic: [QuadraticCost; 2],
    linear: Vec<LinearCost>,
    last_block: usize,
}

impl Cost {
    pub(super) fn new(max_horizon: usize) -> Self {
        let linear = vec![LinearCost::default(); max_horizon / WIDTH + 1];
        Self { quadratic: Default::default(), linear, last_block: 0 }
    }

    /// Copies a problem's cost.
    pub(super) fn start(&mut self, problem: &Problem) {
        let n = problem.horizon;
        let upper = |m: &[[f64; 3]; 3]| [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]];
        let hessian = upper(&problem.q).map(Lanes::all);
        let cost = QuadraticCost { hessian, cross: problem.s.map(Lanes::all) };
        self.quadratic = [cost; 2];
        let (last, end) = place(n);
        self.last_block = last;
        for (lanes, entry) in self.quadratic[1].hessian.iter_mut().zip(upper(&problem.p)) {
            lanes.0[end] = entry;
        }
        for lanes in &mut self.quadratic[1].cross {
            lanes.0[end] = 0.0;
        }
        self.linear[last] = LinearCost::default();
        for (k, (q, r)) in problem.q_lin[..n].iter().zip(&problem.r_lin).enumerate() {
            self.set_linear(k, q, *r);
        }
        self.set_linear(n, &problem.p_lin, 0.0);
    }

    fn set_linear(&mut self, k: usize, q: &[f64; 3], r: f64) {
        let (j, lane) = place(k);
        let block = &mut self.linear[j];
        for (lanes, q) in block.state.iter_mut().zip(q) {
            lanes.0[lane] = *q;
        }
        block.input.0[lane] = r;
    }

    /// Returns the model of block `j` without any pairs.
    #[inline(always)]
    pub(super) fn model(&self, j: usize, r: f64, path: &PathBlock) -> BlockModel {
        let PathBlock { u, x } = path;
        let QuadraticCost { hessian, cross } = &self.quadratic[usize::from(j == self.last_block)];
        let LinearCost { state, input } = &self.linear[j];
        let [q00, q01, q02, q11, q12, q22] = *hessian;
        let gradient = [
            product(&[q00, q01, q02], x) + (cross[0] * *u + state[0]),
            product(&[q01, q11, q12], x) + (cross[1] * *u + state[1]),
            product(&[q02, q12, q22], x) + (cross[2] * *u + state[2]),
        ];
        let slope = Lanes::all(r) * *u + product(cross, x) + *input;
        BlockModel { hessian: *hessian, gradient, curvature: Lanes::default(), slope }
    }
}

/// The iterate as models of the stages.
pub(super) struct Models<'a> {
    pub(super) r: f64,
    pub(super) barriers: &'a mut Barriers,
    pub(super) cost: &'a Cost,
    pub(super) iterate: &'a [PathBlock],
    /// Sum of the products of the pairs so far.
    pub(super) gap: Lanes,
}

impl BlockModels for Models<'_> {
    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        let path = &self.iterate[j];
        let mut model = self.cost.model(j, self.r, path);
        self.gap = self.gap + self.barriers.linearize(j, &path.x, &mut model);
        model
    }
}
