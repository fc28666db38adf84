//! The light, over its stages.

use super::pairs::{PROXIMAL, Pairs, greater, largest};
use crate::problem::{LightCost, LightStage, Softness, dot};
use crate::riccati::light_curve::{LightCurve, LightTangent};

/// Variable `p`; pairs `(s, α)`, with a finite threshold `(d_th − p, β)`, and, if soft, `(σ, λ − α)`.
#[derive(Clone, Debug)]
pub(super) struct LightBarrier {
    pub(super) len: usize,
    /// `w`.
    cost: f64,
    threshold: f64,
    penalty: f64,
    is_soft: bool,
    is_capped: bool,
    p: Vec<f64>,
    per_p: Vec<f64>,
    dp: Vec<f64>,
    /// Change of `α`.
    change: Vec<f64>,
    below: Pairs,
    capped: Pairs,
    violation: Pairs,
    /// `W` by stage; entry 0 belongs to stage 1.
    pub(super) curvature: Vec<f64>,
    /// Force against `c`: the predictor's without a change of `D`, or what the corrector adds.
    pub(super) slope: Vec<f64>,
    /// Change of `D` at which the predictor leaves `α` as it is.
    offset: Vec<f64>,
    /// `1/(H + β/(d_th − p))`.
    compliance: Vec<f64>,
}

impl LightBarrier {
    pub(super) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        Self {
            len: 0,
            cost: 0.0,
            threshold: 0.0,
            penalty: 0.0,
            is_soft: false,
            is_capped: false,
            p: zeros(),
            per_p: zeros(),
            dp: zeros(),
            change: zeros(),
            below: Pairs::new(len),
            capped: Pairs::new(len),
            violation: Pairs::new(len),
            curvature: zeros(),
            slope: zeros(),
            offset: zeros(),
            compliance: zeros(),
        }
    }

    /// Starts at half of the margins that the states leave, at least `least`, with multipliers near the
    /// curve: too small ones cost a dozen iterations.
    pub(super) fn start(
        &mut self,
        light: Option<&LightCost>,
        stages: &[LightStage],
        states: &[[f64; 3]],
        least: f64,
        mu: f64,
    ) {
        self.len = stages.len();
        let Some(light) = light else { return };
        self.cost = light.weight;
        self.threshold = light.threshold;
        self.is_capped = light.threshold < f64::INFINITY;
        (self.is_soft, self.penalty) = match light.softness {
            Softness::Hard => (false, f64::INFINITY),
            Softness::Soft { linear, .. } => (true, linear),
        };
        let top = if self.is_capped { 0.5 * self.threshold } else { f64::INFINITY };
        for (k, stage) in stages.iter().enumerate() {
            let d = dot(&stage.gradient, &states[k + 1]) + stage.offset;
            let p = (0.5 * d).max(2.0 * least).min(top);
            let steep = 0.3 * light.weight / (p * p);
            let s = (d - p).max(least);
            let alpha = (mu / s).max(steep).min(0.5 * self.penalty);
            self.p[k] = p;
            self.below.slack[k] = s;
            self.below.multiplier[k] = alpha;
            if self.is_capped {
                let room = self.threshold - p;
                self.capped.slack[k] = room;
                self.capped.multiplier[k] = (mu / room).max(0.1 * steep);
            }
            if self.is_soft {
                let gamma = self.penalty - alpha;
                self.violation.slack[k] = (p + s - d).max(mu / gamma).max(least);
                self.violation.multiplier[k] = gamma;
            }
        }
    }

    /// Models the pairs for the predictor; returns the sum and the number of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, stages: &[LightStage], states: &[[f64; 3]]) -> (f64, usize) {
        let len = self.len;
        if len == 0 {
            return (0.0, 0);
        }
        let mut gap = self.below.invert(len);
        let mut families = 1;
        if self.is_capped {
            gap += self.capped.invert(len);
            families += 1;
        }
        if self.is_soft {
            gap += self.violation.invert(len);
            families += 1;
        }
        let (stages, states) = (&stages[..len], &states[1..=len]);
        let (p, per_p) = (&self.p[..len], &mut self.per_p[..len]);
        let (s, alpha) = (&self.below.slack[..len], &self.below.multiplier[..len]);
        let compliance = &mut self.compliance[..len];
        let (w, offset) = (&mut self.curvature[..len], &mut self.offset[..len]);
        for k in 0..len {
            per_p[k] = 1.0 / p[k];
            compliance[k] = 2.0 * alpha[k] * per_p[k];
            // With t = 0 the new β is free of its old value, and s of its own.
            offset[k] = p[k] - dot(&stages[k].gradient, &states[k]) - stages[k].offset;
        }
        if self.is_capped {
            let (beta, per) = (&self.capped.multiplier[..len], &self.capped.per_slack[..len]);
            for k in 0..len {
                compliance[k] += beta[k] * (2.0 * per_p[k] + per[k]);
            }
        }
        let per_alpha = &self.below.per_multiplier[..len];
        for k in 0..len {
            let soft = 1.0 / compliance[k];
            compliance[k] = soft;
            w[k] = s[k] * per_alpha[k] + soft + PROXIMAL;
            offset[k] += (self.cost * (per_p[k] * per_p[k]) - alpha[k]) * soft;
        }
        if self.is_soft {
            let (sigma, per) =
                (&self.violation.slack[..len], &self.violation.per_multiplier[..len]);
            for k in 0..len {
                w[k] += sigma[k] * per[k];
                // σ's residual and its product's cancel.
            }
        }
        let slope = &mut self.slope[..len];
        for k in 0..len {
            w[k] = 1.0 / w[k];
            slope[k] = alpha[k] + w[k] * offset[k];
        }
        (gap, families * len)
    }

    /// Sets the corrector's targets, and `slope` to what they add.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, tau: f64, trust: f64) {
        self.below.set_targets(self.len, tau, trust);
        if self.is_capped {
            self.capped.set_targets(self.len, tau, trust);
        }
        if self.is_soft {
            self.violation.set_targets(self.len, tau, trust);
        }
        let len = self.len;
        let slope = &mut self.slope[..len];
        let (t, pm) = (&self.below.target[..len], &self.below.per_multiplier[..len]);
        for k in 0..len {
            slope[k] = t[k] * pm[k];
        }
        if self.is_capped {
            let (t, ps) = (&self.capped.target[..len], &self.capped.per_slack[..len]);
            let compliance = &self.compliance[..len];
            for k in 0..len {
                slope[k] -= t[k] * ps[k] * compliance[k];
            }
        }
        if self.is_soft {
            let (t, pm) = (&self.violation.target[..len], &self.violation.per_multiplier[..len]);
            for k in 0..len {
                slope[k] -= t[k] * pm[k];
            }
        }
        let w = &self.curvature[..len];
        for k in 0..len {
            slope[k] *= w[k];
        }
    }

    /// Takes the sweep's changes of the states.
    #[inline(always)]
    pub(super) fn expand(&mut self, stages: &[LightStage], changes: &[[f64; 3]], corrected: bool) {
        let len = self.len;
        let add = if corrected { 1.0 } else { 0.0 };
        let (stages, changes) = (&stages[..len], &changes[1..=len]);
        let (w, offset, slope) = (&self.curvature[..len], &self.offset[..len], &self.slope[..len]);
        let change = &mut self.change[..len];
        for k in 0..len {
            change[k] = w[k] * (offset[k] - dot(&stages[k].gradient, &changes[k])) + add * slope[k];
        }
        let change = &self.change[..len];
        let (per_p, compliance) = (&self.per_p[..len], &self.compliance[..len]);
        let dp = &mut self.dp[..len];
        let Pairs { multiplier, per_slack, per_multiplier, relative, target, .. } = &mut self.below;
        let (alpha, per_alpha) = (&multiplier[..len], &per_multiplier[..len]);
        let (t, ps, r) = (&target[..len], &per_slack[..len], &mut relative[..len]);
        for k in 0..len {
            dp[k] = self.cost * (per_p[k] * per_p[k]) - alpha[k] - change[k];
            r[k] = (t[k] * ps[k] - change[k]) * per_alpha[k] - 1.0;
        }
        if self.is_capped {
            let Pairs { per_slack, relative, target, .. } = &mut self.capped;
            let (t, ps, r) = (&target[..len], &per_slack[..len], &mut relative[..len]);
            for k in 0..len {
                dp[k] -= t[k] * ps[k];
                r[k] = -dp[k] * compliance[k] * ps[k];
            }
        }
        for k in 0..len {
            dp[k] *= compliance[k];
        }
        if self.is_soft {
            let Pairs { per_slack, per_multiplier, relative, target, .. } = &mut self.violation;
            let (t, ps, pm) = (&target[..len], &per_slack[..len], &per_multiplier[..len]);
            let r = &mut relative[..len];
            for k in 0..len {
                r[k] = (t[k] * ps[k] + change[k]) * pm[k] - 1.0;
            }
        }
    }

    #[inline(always)]
    fn reach_p(&self) -> f64 {
        largest(self.len, [&self.dp, &self.per_p], |[dp, per_p]| greater(-dp * per_p, 0.0))
    }

    #[inline(always)]
    pub(super) fn affine_step_reciprocal(&self) -> f64 {
        let mut step_reciprocal = self.below.affine_step_reciprocal(self.len).max(self.reach_p());
        if self.is_capped {
            step_reciprocal = step_reciprocal.max(self.capped.affine_step_reciprocal(self.len));
        }
        if self.is_soft {
            step_reciprocal = step_reciprocal.max(self.violation.affine_step_reciprocal(self.len));
        }
        step_reciprocal
    }

    #[inline(always)]
    pub(super) fn gap_after_affine(&self, a: f64) -> f64 {
        let mut gap = self.below.gap_after_affine(self.len, a);
        if self.is_capped {
            gap += self.capped.gap_after_affine(self.len, a);
        }
        if self.is_soft {
            gap += self.violation.gap_after_affine(self.len, a);
        }
        gap
    }

    #[inline(always)]
    pub(super) fn step_reciprocal(&self) -> f64 {
        let mut step_reciprocal = self.below.step_reciprocal(self.len).max(self.reach_p());
        if self.is_capped {
            step_reciprocal = step_reciprocal.max(self.capped.step_reciprocal(self.len));
        }
        if self.is_soft {
            step_reciprocal = step_reciprocal.max(self.violation.step_reciprocal(self.len));
        }
        step_reciprocal
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, a: f64) {
        self.below.advance(self.len, a);
        if self.is_capped {
            self.capped.advance(self.len, a);
        }
        if self.is_soft {
            self.violation.advance(self.len, a);
        }
        for (p, dp) in self.p[..self.len].iter_mut().zip(&self.dp) {
            *p += a * dp;
        }
    }

    /// The part of the light's graph that entry `k` goes to.
    pub(super) fn tangent(&self, curve: &LightCurve, k: usize) -> LightTangent {
        if !self.below.is_active(k) {
            curve.clear()
        } else if self.is_capped && self.capped.is_active(k) {
            curve.edge(self.below.multiplier[k])
        } else if self.is_soft && !self.violation.is_active(k) {
            curve.straight()
        } else {
            curve.hyperbola_at(self.p[k])
        }
    }

    pub(super) fn multipliers(&self) -> &[f64] {
        &self.below.multiplier[..self.len]
    }
}
