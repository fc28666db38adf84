//! The problem in its inputs alone, factored once for its matrices.
//!
//! The *left sides* are the inputs, then each row's `g'x_k` of stages 1 to `N`. Without inequalities they are linear in
//! the first state. A multiplier `μ_j` of left side `j` lowers all of them by `S_j μ_j`. Both come from the stages'
//! gains: one column of the recursion backwards ([`crate::riccati::lqr`]), one roll-out forwards.

use super::MAX_SHORT;
use crate::limits::MAX_ROWS;
use crate::problem::Problem;
use crate::riccati::lanes::WIDTH;
use crate::riccati::lqr::{Cost, GENERAL, Gain, LinearQuadratic, Sweep, Unconstrained};

#[derive(Clone, Debug)]
pub(super) struct Condensed {
    /// Build of the problem that the factors are made from.
    made_from: Option<u64>,
    pub(super) cost: Cost,
    pub(super) sweep: Sweep,
    /// Number of inputs, which are the first left sides.
    pub(super) inputs: usize,
    /// Number of left sides, and the distance of their columns: whole blocks.
    pub(super) len: usize,
    pub(super) stride: usize,
    /// Left sides by component of the first state.
    of_state: Vec<f64>,
    /// `S`, column by column.
    response: Vec<f64>,
    /// `1/√S_jj`; 0 for a left side that no input changes.
    pub(super) scale: Vec<f64>,
}

impl Condensed {
    pub(super) fn new(max_horizon: usize) -> Self {
        let horizon = max_horizon.min(MAX_SHORT);
        let stride = (horizon * (1 + MAX_ROWS)).next_multiple_of(WIDTH);
        Self {
            made_from: None,
            cost: Cost::new(horizon),
            sweep: Sweep::new(horizon),
            inputs: 0,
            len: 0,
            stride: 0,
            of_state: vec![0.0; 3 * stride],
            response: vec![0.0; stride * stride],
            scale: vec![0.0; stride],
        }
    }

    #[inline(always)]
    pub(super) fn column(&self, j: usize) -> &[f64] {
        &self.response[j * self.stride..(j + 1) * self.stride]
    }

    /// Factors the problem, unless it is that of the last call.
    pub(super) fn factor(&mut self, problem: &Problem) {
        if self.made_from == Some(problem.build) {
            return;
        }
        self.made_from = Some(problem.build);
        let (n, lq) = (problem.horizon, &LinearQuadratic::new(problem));
        self.cost.start(problem);
        lq.factor(problem, &mut Unconstrained(&self.cost), &mut self.sweep, n);
        self.inputs = n;
        self.len = n * (1 + problem.rows.len());
        self.stride = self.len.next_multiple_of(WIDTH);
        let (len, stride) = (self.len, self.stride);
        let gains = &self.sweep.gains[..n];
        for (i, column) in self.of_state.chunks_mut(stride).take(3).enumerate() {
            let mut x = [0.0; 3];
            x[i] = 1.0;
            roll_out(problem, lq, gains, &[0.0; MAX_SHORT], x, column);
        }
        for j in 0..len {
            let column = &mut self.response[j * stride..(j + 1) * stride];
            let mut offsets = [0.0; MAX_SHORT];
            let mut v = [0.0; 3];
            for k in (0..n).rev() {
                if j >= n && (j - n) % n == k {
                    v = problem.rows[(j - n) / n].gradient;
                }
                let f = lq.input_of::<GENERAL>(&v) + if j == k { 1.0 } else { 0.0 };
                let next = lq.transposed::<GENERAL>(&v);
                v = std::array::from_fn(|i| next[i] - gains[k].feedback[i] * f);
                offsets[k] = -f * gains[k].inverse;
            }
            roll_out(problem, lq, gains, &offsets, [0.0; 3], column);
            let own = column[j];
            self.scale[j] = if own > f64::MIN_POSITIVE { 1.0 / own.sqrt() } else { 0.0 };
        }
        self.scale[len..stride].fill(0.0);
    }

    /// Writes the left sides without inequalities, for a problem without linear terms.
    #[inline(always)]
    pub(super) fn free(&self, x: &[f64; 3], left: &mut [f64]) {
        let stride = self.stride;
        let (first, rest) = self.of_state.split_at(stride);
        let (second, third) = rest.split_at(stride);
        let columns = first.iter().zip(second).zip(third);
        for (slot, ((a, b), c)) in left[..stride].iter_mut().zip(columns) {
            *slot = a * x[0] + b * x[1] + c * x[2];
        }
    }
}

/// Writes the left sides of `u = −feedback·x − offset` from `x` on; a column of [`Condensed`] has the opposite sign.
fn roll_out(
    problem: &Problem,
    lq: &LinearQuadratic,
    gains: &[Gain],
    offsets: &[f64; MAX_SHORT],
    mut x: [f64; 3],
    left: &mut [f64],
) {
    let n = gains.len();
    left.fill(0.0);
    for k in 0..n {
        let u = -gains[k].input(offsets[k], &x);
        x = lq.step::<GENERAL>(&x, u);
        set_stage(problem, k, u, &x, left);
    }
}

/// Writes the left sides of input `k` and of stage `k + 1`.
#[inline(always)]
pub(super) fn set_stage(problem: &Problem, k: usize, u: f64, x: &[f64; 3], left: &mut [f64]) {
    let n = problem.horizon;
    left[k] = u;
    for (j, row) in problem.rows.iter().enumerate() {
        left[n * (1 + j) + k] = crate::problem::dot(&row.gradient, x);
    }
}
