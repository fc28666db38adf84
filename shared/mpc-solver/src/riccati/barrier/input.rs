//! Both bounds of all inputs.

use super::pairs::Pairs;

/// Pairs `(u − u_min, λ_l)` and `(u_max − u, λ_u)`.
#[derive(Clone, Debug)]
pub(in crate::riccati) struct InputBarrier {
    len: usize,
    pub(in crate::riccati) u: Vec<f64>,
    lower: Pairs,
    upper: Pairs,
    /// `W_k`.
    pub(in crate::riccati) weight: Vec<f64>,
    /// What the corrector adds to the gradient on `u_k`.
    pub(in crate::riccati) push: Vec<f64>,
}

impl InputBarrier {
    pub(in crate::riccati) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        let (lower, upper) = (Pairs::new(len), Pairs::new(len));
        Self { len: 0, u: zeros(), lower, upper, weight: zeros(), push: zeros() }
    }

    /// Starts at `inputs`, kept `margin` (of the range) away from the bounds, with products `mu`.
    pub(in crate::riccati) fn start(
        &mut self,
        inputs: &[f64],
        (lo, hi): (f64, f64),
        margin: f64,
        mu: f64,
    ) {
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
    /// With `t = 0` the multipliers' new values leave nothing but `W du`: `push` is zero.
    pub(in crate::riccati) fn predict(&mut self) -> (f64, usize) {
        let len = self.len;
        let gap = self.lower.invert(len) + self.upper.invert(len);
        let (ll, lu) = (&self.lower.multiplier[..len], &self.upper.multiplier[..len]);
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let w = &mut self.weight[..len];
        for k in 0..len {
            w[k] = ll[k] * pl[k] + lu[k] * pu[k];
        }
        (gap, 2 * len)
    }

    /// Sets `push` to what the corrector's targets add.
    pub(in crate::riccati) fn correct(&mut self, tau: f64, trust: f64) {
        let len = self.len;
        self.lower.aim(len, tau, trust);
        self.upper.aim(len, tau, trust);
        let (tl, tu) = (&self.lower.target[..len], &self.upper.target[..len]);
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let push = &mut self.push[..len];
        for k in 0..len {
            push[k] = tu[k] * pu[k] - tl[k] * pl[k];
        }
    }

    /// Takes the sweep's changes of the inputs.
    pub(in crate::riccati) fn follow(&mut self, changes: &[f64]) {
        let len = self.len;
        let du = &changes[..len];
        let (pl, pu) = (&self.lower.per_slack[..len], &self.upper.per_slack[..len]);
        let (rl, ru) = (&mut self.lower.relative[..len], &mut self.upper.relative[..len]);
        for k in 0..len {
            rl[k] = du[k] * pl[k];
            ru[k] = -du[k] * pu[k];
        }
    }

    pub(in crate::riccati) fn reach_affine(&self) -> f64 {
        self.lower.reach_affine(self.len).max(self.upper.reach_affine(self.len))
    }

    pub(in crate::riccati) fn gap_affine(&self, a: f64) -> f64 {
        self.lower.gap_affine(self.len, a) + self.upper.gap_affine(self.len, a)
    }

    pub(in crate::riccati) fn reach(&self) -> f64 {
        self.lower.reach(self.len).max(self.upper.reach(self.len))
    }

    pub(in crate::riccati) fn advance(&mut self, changes: &[f64], a: f64) {
        self.lower.advance(self.len, a);
        self.upper.advance(self.len, a);
        for (u, du) in self.u[..self.len].iter_mut().zip(changes) {
            *u += a * du;
        }
    }

    /// The bound that `u_k` goes to: −1, 0 (none) or 1.
    pub(in crate::riccati) fn side(&self, k: usize) -> i8 {
        i8::from(self.upper.closes(k)) - i8::from(self.lower.closes(k))
    }
}
