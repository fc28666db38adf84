//! Inequalities of the light over its stages.

use super::pairs::{
    Lengths, Limits, ONE, PROXIMAL, Pairs, Prediction, Targets, add_slope, place, product,
};
use crate::problem::{LightCost, LightStage, Softness, dot};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::light_curve::{LightCurve, LightTangent};
use crate::riccati::lqr::BlockModel;

/// The light at a block of stages: variable `p`; pairs `(s, α)`, with a finite threshold `(d_th −
/// p, β)`, and, if soft, `(σ, λ − α)`.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// `c`, `o`.
    gradient: [Lanes; 3],
    constant: Lanes,
    /// 1 at the light's stages; 0 beyond, where nothing changes.
    is_lit: Lanes,
    p: Lanes,
    per_p: Lanes,
    dp: Lanes,
    below: Pairs,
    capped: Pairs,
    violation: Pairs,
    /// `W`.
    curvature: Lanes,
    /// Force against `c`: the predictor's for a zero change of `D`, or the corrector's addition.
    slope: Lanes,
    /// Change of `D` at which the predictor leaves `α` unchanged.
    offset: Lanes,
    /// `1/(H + β/(d_th − p))`.
    compliance: Lanes,
}

/// All blocks of the light.
#[derive(Clone, Debug)]
pub(super) struct LightBarrier {
    /// Stages `1..=len`, in `count` blocks.
    len: usize,
    count: usize,
    /// `w`.
    cost: f64,
    threshold: f64,
    penalty: f64,
    is_soft: bool,
    is_capped: bool,
    blocks: Vec<Block>,
}

impl LightBarrier {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            len: 0,
            count: 0,
            cost: 0.0,
            threshold: 0.0,
            penalty: 0.0,
            is_soft: false,
            is_capped: false,
            blocks: vec![Block::default(); max_horizon / WIDTH + 1],
        }
    }

    /// Starts at half of the margins that the states leave, at least at `least`. Multipliers are
    /// near the curve, as too small ones cost a dozen iterations.
    pub(super) fn start(
        &mut self,
        light: Option<&LightCost>,
        stages: &[LightStage],
        states: &[[f64; 3]],
        least: f64,
        mu: f64,
    ) {
        self.len = stages.len();
        self.count = if stages.is_empty() { 0 } else { self.len / WIDTH + 1 };
        let Some(light) = light else { return };
        self.cost = light.weight;
        self.threshold = light.threshold;
        self.is_capped = light.threshold < f64::INFINITY;
        self.is_soft = light.softness != Softness::Hard;
        (self.penalty, _) = light.softness.penalty();
        for block in &mut self.blocks[..self.count] {
            let product = Pairs::new(ONE, Lanes::all(mu));
            let (below, capped, violation) = (product, product, product);
            *block = Block { p: ONE, below, capped, violation, ..Block::default() };
        }
        let top = if self.is_capped { 0.5 * self.threshold } else { f64::INFINITY };
        for (k, stage) in (1..).zip(stages) {
            let d = dot(&stage.gradient, &states[k]) + stage.offset;
            let p = (0.5 * d).max(2.0 * least).min(top);
            let steep = 0.3 * light.weight / (p * p);
            let s = (d - p).max(least);
            let alpha = (mu / s).max(steep).min(0.5 * self.penalty);
            let (j, lane) = place(k);
            let block = &mut self.blocks[j];
            for (lanes, c) in block.gradient.iter_mut().zip(stage.gradient) {
                lanes.0[lane] = c;
            }
            block.constant.0[lane] = stage.offset;
            block.is_lit.0[lane] = 1.0;
            block.p.0[lane] = p;
            block.below.set(lane, s, alpha);
            if self.is_capped {
                let room = self.threshold - p;
                block.capped.set(lane, room, (mu / room).max(0.1 * steep));
            }
            if self.is_soft {
                let gamma = self.penalty - alpha;
                let sigma = (p + s - d).max(mu / gamma).max(least);
                block.violation.set(lane, sigma, gamma);
            }
        }
    }

    /// Returns the number of pairs.
    pub(super) fn pairs(&self) -> usize {
        let families = 1 + usize::from(self.is_capped) + usize::from(self.is_soft);
        families * WIDTH * self.count
    }

    /// Models the pairs of a block for the predictor; returns the sum of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, x: &[Lanes; 3], model: &mut BlockModel) -> Lanes {
        let (cost, is_capped, is_soft) = (Lanes::all(self.cost), self.is_capped, self.is_soft);
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return Lanes::default() };
        let mut gap = block.below.invert();
        let Pairs { slack: s, multiplier: alpha, per_multiplier: per_alpha, .. } = block.below;
        let (p, per_p) = (block.p, ONE / block.p);
        let mut stiffness = Lanes::all(2.0) * alpha * per_p;
        if is_capped {
            gap = gap + block.capped.invert();
            let Pairs { multiplier: beta, per_slack, .. } = block.capped;
            stiffness = stiffness + beta * (Lanes::all(2.0) * per_p + per_slack);
        }
        let soft = ONE / stiffness;
        let mut compliance = s * per_alpha + soft + Lanes::all(PROXIMAL);
        if is_soft {
            gap = gap + block.violation.invert();
            // The residuals of σ and of its product cancel.
            compliance = compliance + block.violation.slack * block.violation.per_multiplier;
        }
        let w = ONE / compliance;
        // With t = 0 the new β does not depend on its old value, nor s on its own.
        let offset = (p - product(&block.gradient, x) - block.constant)
            + (cost * (per_p * per_p) - alpha) * soft;
        block.per_p = per_p;
        block.compliance = soft;
        block.curvature = w;
        block.offset = offset;
        block.slope = alpha + w * offset;
        // Beyond the light's stages, `c` is zero.
        model.add(&block.gradient, w, -block.slope);
        gap
    }

    /// Applies the predictor's changes of a block's states.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, dx: &[Lanes; 3], prediction: &mut Prediction) {
        let (cost, is_capped, is_soft) = (Lanes::all(self.cost), self.is_capped, self.is_soft);
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return };
        let lit = block.is_lit;
        let change = block.curvature * (block.offset - product(&block.gradient, dx));
        let Block { below, capped, violation, per_p, compliance, .. } = block;
        let dp = (cost * (*per_p * *per_p) - below.multiplier - change) * *compliance;
        below.predict(lit * (-(change * below.per_multiplier) - ONE), prediction);
        if is_capped {
            capped.predict(lit * -(dp * capped.per_slack), prediction);
        }
        if is_soft {
            violation.predict(lit * (change * violation.per_multiplier - ONE), prediction);
        }
        let limits = &mut prediction.limits;
        limits.primal = (lit * -(dp * *per_p)).greater(limits.primal);
    }

    /// Sets the corrector's targets of a block, and adds their term to the gradient.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets, added: &mut [Lanes; 3]) {
        let (is_capped, is_soft) = (self.is_capped, self.is_soft);
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return };
        let Block { below, capped, violation, .. } = block;
        below.set_targets(targets);
        let mut moved = below.target * below.per_multiplier;
        if is_capped {
            capped.set_targets(targets);
            moved = moved - capped.target * capped.per_slack * block.compliance;
        }
        if is_soft {
            violation.set_targets(targets);
            moved = moved - violation.target * violation.per_multiplier;
        }
        block.slope = moved * block.curvature;
        add_slope(added, &block.gradient, -block.slope);
    }

    /// Applies the step's changes of a block's states.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, dx: &[Lanes; 3], limits: &mut Limits) {
        let (cost, is_capped, is_soft) = (Lanes::all(self.cost), self.is_capped, self.is_soft);
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return };
        let lit = block.is_lit;
        let change = block.curvature * (block.offset - product(&block.gradient, dx)) + block.slope;
        let Block { below, capped, violation, per_p, compliance, .. } = block;
        let mut pull = cost * (*per_p * *per_p) - below.multiplier - change;
        let r = (below.target * below.per_slack - change) * below.per_multiplier - ONE;
        below.correct(lit * r, limits);
        if is_capped {
            pull = pull - capped.target * capped.per_slack;
        }
        let dp = lit * (pull * *compliance);
        if is_capped {
            capped.correct(-(dp * capped.per_slack), limits);
        }
        if is_soft {
            let r = (violation.target * violation.per_slack + change) * violation.per_multiplier;
            violation.correct(lit * (r - ONE), limits);
        }
        limits.primal = (-(dp * *per_p)).greater(limits.primal);
        block.dp = dp;
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, lengths: Lengths) {
        let (is_capped, is_soft) = (self.is_capped, self.is_soft);
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return };
        block.below.advance(lengths);
        if is_capped {
            block.capped.advance(lengths);
        }
        if is_soft {
            block.violation.advance(lengths);
        }
        block.p = block.p + Lanes::all(lengths.primal) * block.dp;
    }

    /// Writes the parts of the light's graph that the stages approach, from stage 1 on.
    pub(super) fn suggest(&self, curve: &LightCurve, tangents: &mut [LightTangent]) {
        for (j, block) in self.blocks[..self.count].iter().enumerate() {
            let acts = block.below.are_active();
            let (is_capped, is_kept) = (block.capped.are_active(), block.violation.are_active());
            let first = WIDTH * j;
            for k in first.max(1)..(first + WIDTH).min(self.len + 1) {
                let lane = k - first;
                tangents[k - 1] = if !acts[lane] {
                    curve.clear()
                } else if self.is_capped && is_capped[lane] {
                    curve.edge(block.below.multiplier.0[lane])
                } else if self.is_soft && !is_kept[lane] {
                    curve.straight()
                } else {
                    curve.hyperbola_at(block.p.0[lane])
                };
            }
        }
    }

    /// Copies the multipliers of its stages to `multipliers`.
    pub(super) fn read(&self, multipliers: &mut [f64]) {
        for k in 1..=self.len {
            let (j, lane) = place(k);
            multipliers[k] = self.blocks[j].below.multiplier.0[lane];
        }
    }
}
