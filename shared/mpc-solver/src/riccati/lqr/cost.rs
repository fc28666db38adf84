//! The cost, and functions beside it, as models of [`WIDTH`] stages at a time.

use crate::problem::Problem;
use crate::riccati::lanes::{Lanes, WIDTH};

/// Hessians and gradients of [`WIDTH`] stages: cost and models of the inequalities together.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::riccati) struct BlockModel {
    /// Hessian of the state: entries 00, 01, 02, 11, 12, 22.
    pub(in crate::riccati) hessian: [Lanes; 6],
    pub(in crate::riccati) gradient: [Lanes; 3],
    /// Curvature of the input, without the cost's `r`.
    pub(in crate::riccati) curvature: Lanes,
    pub(in crate::riccati) slope: Lanes,
}

impl BlockModel {
    /// Adds a function of `g'x` by its curvature and its slope.
    #[inline(always)]
    pub(in crate::riccati) fn add(&mut self, g: &[Lanes; 3], curvature: Lanes, slope: Lanes) {
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
struct Quadratic {
    hessian: [Lanes; 6],
    cross: [Lanes; 3],
}

/// `q_k` and `ρ_k`; `p` at the end of the horizon, zero beyond.
#[derive(Clone, Copy, Debug, Default)]
struct Linear {
    state: [Lanes; 3],
    input: Lanes,
}

#[derive(Clone, Debug)]
pub(in crate::riccati) struct Cost {
    /// Quadratic cost of all blocks but the last, and of the last one.
    quadratic: [Quadratic; 2],
    linear: Vec<Linear>,
    last_block: usize,
}

impl Cost {
    pub(in crate::riccati) fn new(max_horizon: usize) -> Self {
        let linear = vec![Linear::default(); max_horizon / WIDTH + 1];
        Self { quadratic: Default::default(), linear, last_block: 0 }
    }

    pub(in crate::riccati) fn start(&mut self, problem: &Problem) {
        let n = problem.horizon;
        let upper = |m: &[[f64; 3]; 3]| [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]];
        let hessian = upper(&problem.q).map(Lanes::all);
        self.quadratic = [Quadratic { hessian, cross: problem.s.map(Lanes::all) }; 2];
        let (last, end) = (n / WIDTH, n % WIDTH);
        self.last_block = last;
        for (lanes, entry) in self.quadratic[1].hessian.iter_mut().zip(upper(&problem.p)) {
            lanes.0[end] = entry;
        }
        for lanes in &mut self.quadratic[1].cross {
            lanes.0[end] = 0.0;
        }
        self.linear[last] = Linear::default();
        for (k, (q, r)) in problem.q_lin[..n].iter().zip(&problem.r_lin).enumerate() {
            self.set_linear(k, q, *r);
        }
        self.set_linear(n, &problem.p_lin, 0.0);
    }

    fn set_linear(&mut self, k: usize, q: &[f64; 3], r: f64) {
        let block = &mut self.linear[k / WIDTH];
        for (lanes, q) in block.state.iter_mut().zip(q) {
            lanes.0[k % WIDTH] = *q;
        }
        block.input.0[k % WIDTH] = r;
    }

    /// Returns the model of block `j` at the origin.
    #[inline(always)]
    pub(in crate::riccati) fn block(&self, j: usize) -> BlockModel {
        let Linear { state, input } = self.linear[j];
        let Quadratic { hessian, .. } = self.quadratic[usize::from(j == self.last_block)];
        BlockModel { hessian, gradient: state, curvature: Lanes::default(), slope: input }
    }

    /// Returns the model of block `j` at inputs and states; `r` is the cost of an input.
    #[inline(always)]
    pub(in crate::riccati) fn block_at(
        &self,
        j: usize,
        r: f64,
        u: Lanes,
        x: &[Lanes; 3],
    ) -> BlockModel {
        let mut model = self.block(j);
        let cross = &self.quadratic[usize::from(j == self.last_block)].cross;
        let [q00, q01, q02, q11, q12, q22] = model.hessian;
        let product = |g: [Lanes; 3]| g[0] * x[0] + g[1] * x[1] + g[2] * x[2];
        let rows = [[q00, q01, q02], [q01, q11, q12], [q02, q12, q22]];
        for i in 0..3 {
            model.gradient[i] = product(rows[i]) + (cross[i] * u + model.gradient[i]);
        }
        model.slope = Lanes::all(r) * u + product(*cross) + model.slope;
        model
    }
}
