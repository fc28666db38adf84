//! Inequalities of one row, or of the light, over their stages.
//!
//! The light `D = c'x + o ≥ p` is the row `−c'x ≤ o` with a variable `p` of its own, which the hyperbola moves.

use super::pairs::{ONE, PROXIMAL, Pairs, Prediction, Targets, add_slope, place, product};
use crate::problem::{LightCost, Problem, Row, Softness, dot};
use crate::riccati::curve::{Curve, Tangent};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::BlockModel;

/// Limit from which on a stage counts as free: no cruise state comes near it.
const NO_LIMIT: f64 = 1e9;

/// A block of stages: pairs `(s, μ)` and, if soft, `(σ, ν)`; with a hyperbola also the variable `p` and, with a finite
/// threshold, `(d_th − p, β)`.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// `g` and `h`; zero at stages without a limit, whose pairs then stay.
    gradient: [Lanes; 3],
    limit: Lanes,
    /// 1 at stages with a limit, 0 elsewhere.
    is_in_force: Lanes,
    below: Pairs,
    violation: Pairs,
    capped: Pairs,
    p: Lanes,
    per_p: Lanes,
    dp: Lanes,
    /// `W`.
    curvature: Lanes,
    /// Force on `g`: the predictor's for a zero change of `z`, or the corrector's addition.
    slope: Lanes,
    /// Change of `z` at which the predictor leaves the multiplier unchanged.
    offset: Lanes,
    /// `1/(ν + κσ)`, and `λ + κσ − μ`, the target of `ν`.
    per_stiffness: Lanes,
    price: Lanes,
    /// `1/(2(α + β)/p + β/(d_th − p))`.
    compliance: Lanes,
}

/// Which pairs a bound has, with their constants.
#[derive(Clone, Copy, Debug, Default)]
struct Form {
    /// `(λ, κ)`.
    penalty: Option<(f64, f64)>,
    /// `w`.
    hyperbola: Option<f64>,
    is_capped: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Bound {
    form: Form,
    /// First stage, and one past the last.
    from: usize,
    end: usize,
    /// First block, and one past the last.
    first_block: usize,
    end_block: usize,
    blocks: Vec<Block>,
}

/// Least slack and product of a start.
#[derive(Clone, Copy)]
pub(super) struct StartPairs {
    pub(super) slack: f64,
    pub(super) mu: f64,
}

impl Bound {
    pub(super) fn new(max_horizon: usize) -> Self {
        let blocks = vec![Block::default(); max_horizon / WIDTH + 1];
        Self { form: Form::default(), from: 0, end: 0, first_block: 0, end_block: 0, blocks }
    }

    /// Starts with the slacks that the states leave.
    pub(super) fn start_row(
        &mut self,
        row: &Row,
        limits: &[f64],
        states: &[[f64; 3]],
        start: StartPairs,
    ) {
        let penalty = (row.softness != Softness::Hard).then(|| row.softness.penalty());
        self.clear(row.from, row.from.max(row.to + 1), Form { penalty, ..Form::default() }, start);
        for k in self.from..self.end {
            if limits[k] < NO_LIMIT {
                let room = limits[k] - dot(&row.gradient, &states[k]);
                self.set(k, row.gradient, limits[k], room, (0.0, 0.0), start);
            }
        }
    }

    /// Starts at half of the margins that the states leave. Multipliers are near the curve, as too small ones cost a
    /// dozen iterations.
    pub(super) fn start_light(
        &mut self,
        light: &LightCost,
        problem: &Problem,
        states: &[[f64; 3]],
        start: StartPairs,
    ) {
        let penalty = (light.softness != Softness::Hard).then(|| (light.softness.penalty().0, 0.0));
        let is_capped = light.threshold < f64::INFINITY;
        let form = Form { penalty, hyperbola: Some(light.weight), is_capped };
        self.clear(1, problem.light_len + 1, form, start);
        for (k, stage) in (1..).zip(problem.light_stages()) {
            let d = dot(&stage.gradient, &states[k]) + stage.offset;
            let p = (0.5 * d).max(2.0 * start.slack).min(0.5 * light.threshold);
            let steep = 0.3 * light.weight / (p * p);
            self.set(k, stage.gradient.map(|c| -c), stage.offset, d, (p, steep), start);
            if is_capped {
                let ((j, lane), room) = (place(k), light.threshold - p);
                self.blocks[j].capped.set(lane, room, (start.mu / room).max(0.1 * steep));
            }
        }
    }

    /// Fills the blocks of these stages with pairs that do not move.
    fn clear(&mut self, from: usize, end: usize, form: Form, start: StartPairs) {
        (self.from, self.end, self.form) = (from, end, form);
        (self.first_block, self.end_block) =
            if from == end { (0, 0) } else { (from / WIDTH, end.div_ceil(WIDTH)) };
        let pairs = Pairs::new(ONE, Lanes::all(start.mu));
        let (below, violation, capped) = (pairs, pairs, pairs);
        let free = Block { p: ONE, below, violation, capped, ..Block::default() };
        self.blocks[self.first_block..self.end_block].fill(free);
    }

    /// Sets the pairs of a stage with this `room` from its limit, `p`, and least multiplier.
    fn set(
        &mut self,
        k: usize,
        gradient: [f64; 3],
        limit: f64,
        room: f64,
        (p, steep): (f64, f64),
        StartPairs { slack, mu }: StartPairs,
    ) {
        let (j, lane) = place(k);
        let block = &mut self.blocks[j];
        for (lanes, g) in block.gradient.iter_mut().zip(gradient) {
            lanes.0[lane] = g;
        }
        block.limit.0[lane] = limit;
        block.is_in_force.0[lane] = 1.0;
        block.p.0[lane] = p;
        let s = (room - p).max(slack);
        let mut multiplier = (mu / s).max(steep);
        if let Some((penalty, curvature)) = self.form.penalty {
            multiplier = multiplier.min(0.5 * penalty);
            let sigma = (p + s - room).max(slack);
            block.violation.set(lane, sigma, penalty + curvature * sigma - multiplier);
        }
        block.below.set(lane, s, multiplier);
    }

    pub(super) fn pairs(&self) -> usize {
        let Form { penalty, is_capped, .. } = self.form;
        let families = 1 + usize::from(penalty.is_some()) + usize::from(is_capped);
        families * WIDTH * (self.end_block - self.first_block)
    }

    #[inline(always)]
    fn block(&mut self, j: usize) -> Option<&mut Block> {
        self.blocks[..self.end_block].get_mut(j).filter(|_| j >= self.first_block)
    }

    /// Models the pairs of a block for the predictor; returns the sum of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, x: &[Lanes; 3], model: &mut BlockModel) -> Lanes {
        let form = self.form;
        let Some(block) = self.block(j) else { return Lanes::default() };
        let mut gap = block.below.invert();
        let Pairs { slack: s, multiplier: m, per_multiplier, .. } = block.below;
        // First s + (residual of the slack).
        let mut offset = block.limit - product(&block.gradient, x);
        let mut compliance = s * per_multiplier + Lanes::all(PROXIMAL);
        if let Some(weight) = form.hyperbola {
            let (p, per_p) = (block.p, ONE / block.p);
            let mut stiffness = Lanes::all(2.0) * m * per_p;
            if form.is_capped {
                gap = gap + block.capped.invert();
                let Pairs { multiplier: beta, per_slack, .. } = block.capped;
                stiffness = stiffness + beta * (Lanes::all(2.0) * per_p + per_slack);
            }
            let soft = ONE / stiffness;
            (block.per_p, block.compliance) = (per_p, soft);
            compliance = compliance + soft;
            // With t = 0 the new β does not depend on its old value.
            offset = offset - p - (Lanes::all(weight) * (per_p * per_p) - m) * soft;
        }
        if let Some((weight, curvature)) = form.penalty {
            gap = gap + block.violation.invert();
            let Pairs { slack: sigma, multiplier: nu, .. } = block.violation;
            let stiffness = Lanes::all(curvature) * sigma;
            let soft = ONE / (nu + stiffness);
            block.per_stiffness = soft;
            block.price = Lanes::all(weight) + stiffness - m;
            compliance = compliance + sigma * soft;
            offset = offset + (sigma - sigma * block.price * soft);
        }
        let w = ONE / compliance;
        block.curvature = w;
        block.offset = offset;
        block.slope = m - w * offset;
        // At stages without a limit the gradient is zero.
        model.add(&block.gradient, w, block.slope);
        gap
    }

    /// Applies the predictor's changes of a block's states.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, dx: &[Lanes; 3], prediction: &mut Prediction) {
        let form = self.form;
        let Some(block) = self.block(j) else { return };
        let on = block.is_in_force;
        let dm = block.curvature * (product(&block.gradient, dx) - block.offset);
        let Block { below, violation, capped, per_p, .. } = block;
        below.predict(on * (-(dm * below.per_multiplier) - ONE), prediction);
        if let Some(weight) = form.hyperbola {
            let pull = Lanes::all(weight) * (*per_p * *per_p) - below.multiplier - dm;
            let dp = on * (pull * block.compliance);
            prediction.limit = (-(dp * *per_p)).greater(prediction.limit);
            if form.is_capped {
                capped.predict(-(dp * capped.per_slack), prediction);
            }
        }
        if form.penalty.is_some() {
            violation.predict(on * ((dm - block.price) * block.per_stiffness), prediction);
        }
    }

    /// Sets the corrector's targets of a block, and adds their term to the gradient.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets, added: &mut [Lanes; 3]) {
        let form = self.form;
        let Some(block) = self.block(j) else { return };
        let Block { below, violation, capped, .. } = block;
        below.set_targets(targets);
        let mut moved = below.target * below.per_multiplier;
        if form.is_capped {
            capped.set_targets(targets);
            moved = moved - capped.target * capped.per_slack * block.compliance;
        }
        if form.penalty.is_some() {
            violation.set_targets(targets);
            moved = moved - violation.target * block.per_stiffness;
        }
        block.slope = block.curvature * moved;
        add_slope(added, &block.gradient, block.slope);
    }

    /// Applies the step's changes of a block's states.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, dx: &[Lanes; 3], limit: &mut Lanes) {
        let form = self.form;
        let Some(block) = self.block(j) else { return };
        let on = block.is_in_force;
        let dm = block.curvature * (product(&block.gradient, dx) - block.offset) + block.slope;
        let Block { below, violation, capped, per_p, .. } = block;
        let r = (below.target * below.per_slack - dm) * below.per_multiplier - ONE;
        below.correct(on * r, limit);
        if let Some(weight) = form.hyperbola {
            let mut pull = Lanes::all(weight) * (*per_p * *per_p) - below.multiplier - dm;
            if form.is_capped {
                pull = pull - capped.target * capped.per_slack;
            }
            let dp = on * (pull * block.compliance);
            if form.is_capped {
                capped.correct(-(dp * capped.per_slack), limit);
            }
            *limit = (-(dp * *per_p)).greater(*limit);
            block.dp = dp;
        }
        if form.penalty.is_some() {
            let pull = violation.target * violation.per_slack - block.price + dm;
            violation.correct(on * (pull * block.per_stiffness), limit);
        }
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, length: f64) {
        let form = self.form;
        let Some(block) = self.block(j) else { return };
        block.below.advance(length);
        if form.penalty.is_some() {
            block.violation.advance(length);
        }
        if form.is_capped {
            block.capped.advance(length);
        }
        block.p = block.p + Lanes::all(length) * block.dp;
    }

    /// Writes the parts of the curve that the stages approach; `curve` is that of a stage.
    pub(super) fn suggest(&self, curve: impl Fn(usize) -> Curve, tangents: &mut [Tangent]) {
        tangents.fill(Tangent::default());
        let Form { penalty, hyperbola, is_capped } = self.form;
        for k in self.from..self.end {
            let (j, lane) = place(k);
            let (Block { below, violation, capped, p, .. }, curve) = (&self.blocks[j], curve(k));
            tangents[k] = if !below.are_active()[lane] {
                curve.clear()
            } else if is_capped && capped.are_active()[lane] {
                curve.edge(below.multiplier.0[lane])
            } else if penalty.is_some() && !violation.are_active()[lane] {
                curve.straight()
            } else if hyperbola.is_some() {
                curve.hyperbola_at(p.0[lane])
            } else {
                curve.edge(below.multiplier.0[lane])
            };
        }
    }

    /// Returns the multipliers of the stages, with the stages.
    pub(super) fn multipliers(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        (self.from..self.end).map(|k| {
            let (j, lane) = place(k);
            let Block { below, is_in_force, .. } = &self.blocks[j];
            (k, below.multiplier.0[lane] * is_in_force.0[lane])
        })
    }
}
