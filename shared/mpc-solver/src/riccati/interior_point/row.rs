//! One row, over its stages.

use super::pairs::{PROXIMAL, Pairs};
use crate::problem::{Row, Softness, dot};
use crate::riccati::row_curve::RowTangent;

/// Finite stand-in for an infinite limit.
const NO_LIMIT: f64 = 1e9;

/// Pairs `(s, μ)` and, if soft, `(σ, ν)`.
#[derive(Clone, Debug)]
pub(super) struct RowBarrier {
    pub(super) gradient: [f64; 3],
    /// First stage; the others expand.
    pub(super) from: usize,
    pub(super) len: usize,
    /// `(λ, κ)`.
    penalty: Option<(f64, f64)>,
    limit: Pairs,
    violation: Pairs,
    /// `W` by stage, counted from `from`.
    pub(super) curvature: Vec<f64>,
    /// Force on `g`: the predictor's without a change of `z`, or what the corrector adds.
    pub(super) slope: Vec<f64>,
    /// Change of `z` at which the predictor leaves the multiplier as it is.
    offset: Vec<f64>,
    /// `1/(ν + κσ)`.
    per_stiffness: Vec<f64>,
}

impl RowBarrier {
    pub(super) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        Self {
            gradient: [0.0; 3],
            from: 0,
            len: 0,
            penalty: None,
            limit: Pairs::new(len),
            violation: Pairs::new(len),
            curvature: zeros(),
            slope: zeros(),
            offset: zeros(),
            per_stiffness: zeros(),
        }
    }

    /// Starts with the slacks that the states leave, at least `least`, and products about `mu`.
    pub(super) fn start(
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
        self.penalty = match row.softness {
            Softness::Hard => None,
            Softness::Soft { linear, quadratic } => Some((linear, quadratic)),
        };
        for i in 0..self.len {
            let room =
                within_reach(limits[row.from + i]) - dot(&row.gradient, &states[row.from + i]);
            let s = room.max(least);
            self.limit.slack[i] = s;
            self.limit.multiplier[i] = mu / s;
            if let Some((penalty, curvature)) = self.penalty {
                let m = (mu / s).min(0.5 * penalty);
                self.limit.multiplier[i] = m;
                let sigma = (s - room).max(least);
                self.violation.slack[i] = sigma;
                self.violation.multiplier[i] = penalty + curvature * sigma - m;
            }
        }
    }

    /// Models the pairs for the predictor; returns the sum and the number of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, limits: &[f64], states: &[[f64; 3]]) -> (f64, usize) {
        let len = self.len;
        if len == 0 {
            return (0.0, 0);
        }
        let mut gap = self.limit.invert(len);
        let (h, states) = (&limits[self.from..][..len], &states[self.from..][..len]);
        let (s, m) = (&self.limit.slack[..len], &self.limit.multiplier[..len]);
        let pm = &self.limit.per_multiplier[..len];
        let (w, slope) = (&mut self.curvature[..len], &mut self.slope[..len]);
        let offset = &mut self.offset[..len];
        for i in 0..len {
            // s + (residual of the slack), to begin with.
            offset[i] = within_reach(h[i]) - dot(&self.gradient, &states[i]);
            w[i] = s[i] * pm[i] + PROXIMAL;
        }
        if let Some((_, curvature)) = self.penalty {
            gap += self.violation.invert(len);
            let (sigma, nu) = (&self.violation.slack[..len], &self.violation.multiplier[..len]);
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
            slope[i] = m[i] - w[i] * offset[i];
        }
        (gap, if self.penalty.is_some() { 2 * len } else { len })
    }

    /// Sets the corrector's targets, and `slope` to what they add.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, tau: f64, trust: f64) {
        self.limit.set_targets(self.len, tau, trust);
        if self.penalty.is_some() {
            self.violation.set_targets(self.len, tau, trust);
        }
        let len = self.len;
        let (t, pm) = (&self.limit.target[..len], &self.limit.per_multiplier[..len]);
        let (w, slope) = (&self.curvature[..len], &mut self.slope[..len]);
        if self.penalty.is_some() {
            let (t2, soft) = (&self.violation.target[..len], &self.per_stiffness[..len]);
            for i in 0..len {
                slope[i] = w[i] * (t[i] * pm[i] - t2[i] * soft[i]);
            }
        } else {
            for i in 0..len {
                slope[i] = w[i] * (t[i] * pm[i]);
            }
        }
    }

    /// Takes the sweep's changes of the states.
    #[inline(always)]
    pub(super) fn expand(&mut self, changes: &[[f64; 3]], corrected: bool) {
        let len = self.len;
        let changes = &changes[self.from..][..len];
        let (w, slope, offset) = (&self.curvature[..len], &self.slope[..len], &self.offset[..len]);
        let (t, ps) = (&self.limit.target[..len], &self.limit.per_slack[..len]);
        let pm = &self.limit.per_multiplier[..len];
        let r = &mut self.limit.relative[..len];
        let add = if corrected { 1.0 } else { 0.0 };
        let change =
            |i: usize| w[i] * (dot(&self.gradient, &changes[i]) - offset[i]) + add * slope[i];
        if self.penalty.is_some() {
            let Pairs { multiplier, per_slack, relative, target, .. } = &mut self.violation;
            let (nu, per_sigma, t2) = (&multiplier[..len], &per_slack[..len], &target[..len]);
            let (r2, soft) = (&mut relative[..len], &self.per_stiffness[..len]);
            for i in 0..len {
                let dm = change(i);
                r[i] = (t[i] * ps[i] - dm) * pm[i] - 1.0;
                r2[i] = (t2[i] * per_sigma[i] - nu[i] + dm) * soft[i];
            }
        } else {
            for i in 0..len {
                r[i] = (t[i] * ps[i] - change(i)) * pm[i] - 1.0;
            }
        }
    }

    #[inline(always)]
    pub(super) fn affine_step_reciprocal(&self) -> f64 {
        let limit = self.limit.affine_step_reciprocal(self.len);
        if self.penalty.is_some() {
            limit.max(self.violation.affine_step_reciprocal(self.len))
        } else {
            limit
        }
    }

    #[inline(always)]
    pub(super) fn gap_after_affine(&self, a: f64) -> f64 {
        let gap = self.limit.gap_after_affine(self.len, a);
        if self.penalty.is_some() {
            gap + self.violation.gap_after_affine(self.len, a)
        } else {
            gap
        }
    }

    #[inline(always)]
    pub(super) fn step_reciprocal(&self) -> f64 {
        let limit = self.limit.step_reciprocal(self.len);
        if self.penalty.is_some() {
            limit.max(self.violation.step_reciprocal(self.len))
        } else {
            limit
        }
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, a: f64) {
        self.limit.advance(self.len, a);
        if self.penalty.is_some() {
            self.violation.advance(self.len, a);
        }
    }

    /// The part of the row's graph that stage `k` goes to.
    pub(super) fn tangent(&self, k: usize) -> RowTangent {
        let i = k - self.from;
        match self.penalty {
            _ if !self.limit.is_active(i) => RowTangent::default(),
            Some((penalty, curvature)) if !self.violation.is_active(i) => {
                RowTangent::beyond(penalty, curvature)
            }
            _ => RowTangent::edge(self.limit.multiplier[i]),
        }
    }

    pub(super) fn multipliers(&self) -> &[f64] {
        &self.limit.multiplier[..self.len]
    }
}

/// A limit so far off that no cruise state comes near it stands for no limit at all.
#[inline(always)]
fn within_reach(limit: f64) -> f64 {
    if limit < NO_LIMIT { limit } else { NO_LIMIT }
}
