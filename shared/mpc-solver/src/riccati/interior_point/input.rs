//! Both bounds of all inputs.

use super::pairs::Pairs;
use crate::riccati::working_set::Side;

/// Pairs `(u − u_min, λ_l)` and `(u_max − u, λ_u)`.
#[derive(Clone, Debug)]
pub(super) struct InputBarrier {
    len: usize,
    pub(super) u: Vec<f64>,
    lower: Pairs,
    upper: Pairs,
    /// `W_k`.
    pub(super) curvature: Vec<f64>,
    /// What the corrector adds to the gradient on `u_k`.
    pub(super) slope: Vec<f64>,
}

impl InputBarrier {
    pub(super) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        let (lower, upper) = (Pairs::new(len), Pairs::new(len));
        Self { len: 0, u: zeros(), lower, upper, curvature: zeros(), slope: zeros() }
    }

    /// Starts at `inputs`, kept `margin` (of the range) away from the bounds, with products `mu`.
    pub(super) fn start(&mut self, inputs: &[f64], (lo, hi): (f64, f64), margin: f64, mu: f64) {
        self.len = inputs.len();
        let room = margin * (hi - lo);
        for k in 0..self.len {
            let u = inputs[k].max(lo + room).min(hi - room);
            self.u[k] = u;
            self.lower.slack[k] = u - lo;
            self.upper.slack[k] = hi - u;
            self.lower.multiplier[k] = mu / (u - lo);
            self.upper.multiplier[k] = mu / (hi - u);
        }
    }

    /// Models the pairs for the predictor; returns the sum and the number of the products.
    ///
    /// With `t = 0` the multipliers' new values leave nothing but `W du`: `slope` is zero.
    #[inline(always)]
    pub(super) fn linearize(&mut self) -> (f64, usize) {
        let len = self.len;
        let gap = self.lower.invert(len) + self.upper.invert(len);
        let (ll, lu) = (&self.lower.multiplier[..len], &self.upper.multiplier[..len]);
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let w = &mut self.curvature[..len];
        for k in 0..len {
            w[k] = ll[k] * pl[k] + lu[k] * pu[k];
        }
        (gap, 2 * len)
    }

    /// Sets the corrector's targets, and `slope` to what they add.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, tau: f64, trust: f64) {
        self.lower.set_targets(self.len, tau, trust);
        self.upper.set_targets(self.len, tau, trust);
        let len = self.len;
        let (tl, tu) = (&self.lower.target[..len], &self.upper.target[..len]);
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let slope = &mut self.slope[..len];
        for k in 0..len {
            slope[k] = tu[k] * pu[k] - tl[k] * pl[k];
        }
    }

    /// Takes the sweep's changes of the inputs.
    #[inline(always)]
    pub(super) fn expand(&mut self, changes: &[f64]) {
        let len = self.len;
        let du = &changes[..len];
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let (rl, ru) = (&mut self.lower.relative[..len], &mut self.upper.relative[..len]);
        for k in 0..len {
            rl[k] = du[k] * pl[k];
            ru[k] = -du[k] * pu[k];
        }
    }

    #[inline(always)]
    pub(super) fn affine_step_reciprocal(&self) -> f64 {
        self.lower.affine_step_reciprocal(self.len).max(self.upper.affine_step_reciprocal(self.len))
    }

    #[inline(always)]
    pub(super) fn gap_after_affine(&self, a: f64) -> f64 {
        self.lower.gap_after_affine(self.len, a) + self.upper.gap_after_affine(self.len, a)
    }

    #[inline(always)]
    pub(super) fn step_reciprocal(&self) -> f64 {
        self.lower.step_reciprocal(self.len).max(self.upper.step_reciprocal(self.len))
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, changes: &[f64], a: f64) {
        self.lower.advance(self.len, a);
        self.upper.advance(self.len, a);
        for (u, du) in self.u[..self.len].iter_mut().zip(changes) {
            *u += a * du;
        }
    }

    /// The bound that `u_k` goes to.
    pub(super) fn side(&self, k: usize) -> Side {
        if self.upper.is_active(k) {
            Side::Upper
        } else if self.lower.is_active(k) {
            Side::Lower
        } else {
            Side::Free
        }
    }
}
