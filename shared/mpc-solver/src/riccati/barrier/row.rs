//! One row, over its stages.

use super::PROXIMAL;
use super::pairs::Pairs;
use crate::problem::{Row, Softness, dot};
use crate::riccati::row_graph::RowTangent;

/// Finite stand-in for an infinite limit.
const NO_LIMIT: f64 = 1e9;

/// Pairs `(s, μ)` and, if soft, `(σ, ν)`.
#[derive(Clone, Debug)]
pub(in crate::riccati) struct RowBarrier {
    pub(in crate::riccati) gradient: [f64; 3],
    /// First stage; the others follow.
    pub(in crate::riccati) from: usize,
    pub(in crate::riccati) len: usize,
    /// `(λ, κ)`.
    price: Option<(f64, f64)>,
    limit: Pairs,
    slip: Pairs,
    /// `W` by stage, counted from `from`.
    pub(in crate::riccati) weight: Vec<f64>,
    /// Force on `g`: the predictor's without a change of `z`, or what the corrector adds.
    pub(in crate::riccati) force: Vec<f64>,
    /// Change of `z` at which the predictor leaves the multiplier as it is.
    offset: Vec<f64>,
    /// `1/(ν + κσ)`.
    per_stiffness: Vec<f64>,
}

impl RowBarrier {
    pub(in crate::riccati) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        Self {
            gradient: [0.0; 3],
            from: 0,
            len: 0,
            price: None,
            limit: Pairs::new(len),
            slip: Pairs::new(len),
            weight: zeros(),
            force: zeros(),
            offset: zeros(),
            per_stiffness: zeros(),
        }
    }

    /// Starts with the slacks that the states leave, at least `least`, and products about `mu`.
    pub(in crate::riccati) fn start(
        &mut self,
        row: &Row,
        limits: &[f64],
        states: &[[f64; 3]],
        least: f64,
        mu: f64,
    ) {
        self.gradient = row.gradient;
        self.from = row.from;
        self.len = if row.to >= row.from { row.to - row.from + 1 } else { 0 };
        self.price = match row.softness {
            Softness::Hard => None,
            Softness::Soft { linear, quadratic } => Some((linear, quadratic)),
        };
        for i in 0..self.len {
            let room =
                within_reach(limits[row.from + i]) - dot(&row.gradient, &states[row.from + i]);
            let s = room.max(least);
            self.limit.slack[i] = s;
            self.limit.multiplier[i] = mu / s;
            if let Some((price, curvature)) = self.price {
                let m = (mu / s).min(0.5 * price);
                self.limit.multiplier[i] = m;
                let sigma = (s - room).max(least);
                self.slip.slack[i] = sigma;
                self.slip.multiplier[i] = price + curvature * sigma - m;
            }
        }
    }

    /// Models the pairs for the predictor; returns the sum and the number of the products.
    pub(in crate::riccati) fn predict(
        &mut self,
        limits: &[f64],
        states: &[[f64; 3]],
    ) -> (f64, usize) {
        let len = self.len;
        if len == 0 {
            return (0.0, 0);
        }
        let mut gap = self.limit.invert(len);
        let (h, states) = (&limits[self.from..][..len], &states[self.from..][..len]);
        let (s, m) = (&self.limit.slack[..len], &self.limit.multiplier[..len]);
        let pm = &self.limit.per_multiplier[..len];
        let (w, force) = (&mut self.weight[..len], &mut self.force[..len]);
        let offset = &mut self.offset[..len];
        for i in 0..len {
            // s + (residual of the slack), to begin with.
            offset[i] = within_reach(h[i]) - dot(&self.gradient, &states[i]);
            w[i] = s[i] * pm[i] + PROXIMAL;
        }
        if let Some((_, curvature)) = self.price {
            gap += self.slip.invert(len);
            let (sigma, nu) = (&self.slip.slack[..len], &self.slip.multiplier[..len]);
            let per_stiffness = &mut self.per_stiffness[..len];
            for i in 0..len {
                let soft = 1.0 / (nu[i] + curvature * sigma[i]);
                per_stiffness[i] = soft;
                w[i] += sigma[i] * soft;
                offset[i] += sigma[i] - sigma[i] * nu[i] * soft;
            }
        }
        for i in 0..len {
            w[i] = 1.0 / w[i];
            force[i] = m[i] - w[i] * offset[i];
        }
        (gap, if self.price.is_some() { 2 * len } else { len })
    }

    /// Sets `force` to what the corrector's targets add.
    pub(in crate::riccati) fn correct(&mut self, tau: f64, trust: f64) {
        let len = self.len;
        self.limit.aim(len, tau, trust);
        let (t, pm) = (&self.limit.target[..len], &self.limit.per_multiplier[..len]);
        let (w, force) = (&self.weight[..len], &mut self.force[..len]);
        if self.price.is_some() {
            self.slip.aim(len, tau, trust);
            let (t2, soft) = (&self.slip.target[..len], &self.per_stiffness[..len]);
            for i in 0..len {
                force[i] = w[i] * (t[i] * pm[i] - t2[i] * soft[i]);
            }
        } else {
            for i in 0..len {
                force[i] = w[i] * (t[i] * pm[i]);
            }
        }
    }

    /// Takes the sweep's changes of the states.
    pub(in crate::riccati) fn follow(&mut self, changes: &[[f64; 3]], corrected: bool) {
        let len = self.len;
        let changes = &changes[self.from..][..len];
        let (w, force, offset) = (&self.weight[..len], &self.force[..len], &self.offset[..len]);
        let (t, ps) = (&self.limit.target[..len], &self.limit.per_slack[..len]);
        let pm = &self.limit.per_multiplier[..len];
        let r = &mut self.limit.relative[..len];
        let add = if corrected { 1.0 } else { 0.0 };
        for i in 0..len {
            let dm = w[i] * (dot(&self.gradient, &changes[i]) - offset[i]) + add * force[i];
            r[i] = (t[i] * ps[i] - dm) * pm[i] - 1.0;
            if self.price.is_some() {
                let push = self.slip.target[i] * self.slip.per_slack[i];
                self.slip.relative[i] =
                    (push - self.slip.multiplier[i] + dm) * self.per_stiffness[i];
            }
        }
    }

    pub(in crate::riccati) fn reach_affine(&self) -> f64 {
        let limit = self.limit.reach_affine(self.len);
        if self.price.is_some() { limit.max(self.slip.reach_affine(self.len)) } else { limit }
    }

    pub(in crate::riccati) fn gap_affine(&self, a: f64) -> f64 {
        let gap = self.limit.gap_affine(self.len, a);
        if self.price.is_some() { gap + self.slip.gap_affine(self.len, a) } else { gap }
    }

    pub(in crate::riccati) fn reach(&self) -> f64 {
        let limit = self.limit.reach(self.len);
        if self.price.is_some() { limit.max(self.slip.reach(self.len)) } else { limit }
    }

    pub(in crate::riccati) fn advance(&mut self, a: f64) {
        self.limit.advance(self.len, a);
        if self.price.is_some() {
            self.slip.advance(self.len, a);
        }
    }

    /// The part of the row's graph that stage `k` goes to.
    pub(in crate::riccati) fn tangent(&self, k: usize) -> RowTangent {
        let i = k - self.from;
        match self.price {
            _ if !self.limit.closes(i) => RowTangent::default(),
            Some((price, curvature)) if !self.slip.closes(i) => {
                RowTangent::beyond(price, curvature)
            }
            _ => RowTangent::edge(self.limit.multiplier[i]),
        }
    }

    pub(in crate::riccati) fn multipliers(&self) -> &[f64] {
        &self.limit.multiplier[..self.len]
    }
}

/// A limit so far off that no cruise state comes near it stands for no limit at all.
#[inline(always)]
fn within_reach(limit: f64) -> f64 {
    if limit < NO_LIMIT { limit } else { NO_LIMIT }
}
