//! Inequalities of one row over its stages.

use super::pairs::{
    Lengths, Limits, ONE, PROXIMAL, Pairs, Prediction, Targets, add_slope, place, product,
};
use crate::problem::{Row, Softness, dot};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::BlockModel;
use crate::riccati::row_curve::RowTangent;

/// Finite replacement for an infinite limit.
const NO_LIMIT: f64 = 1e9;

/// The row at a block of stages: pairs `(s, μ)` and, if soft, `(σ, ν)`.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// `h`.
    limit: Lanes,
    /// 1 at the row's stages; 0 beyond, where nothing depends on it.
    is_in_force: Lanes,
    below: Pairs,
    violation: Pairs,
    /// `W`.
    curvature: Lanes,
    /// Force on `g`: the predictor's for a zero change of `z`, or the corrector's addition.
    slope: Lanes,
    /// Change of `z` at which the predictor leaves the multiplier unchanged.
    offset: Lanes,
    /// `1/(ν + κσ)`.
    per_stiffness: Lanes,
    /// `λ + κσ − μ`, the target of `ν`.
    price: Lanes,
}

/// All blocks of a row; lanes beyond its stages have no limit.
#[derive(Clone, Debug)]
pub(super) struct RowBarrier {
    /// `g`, the same in every lane.
    gradient: [Lanes; 3],
    /// First stage, and one past the last.
    from: usize,
    end: usize,
    /// First block, and one past the last.
    first_block: usize,
    end_block: usize,
    /// `(λ, κ)`.
    penalty: Option<(f64, f64)>,
    blocks: Vec<Block>,
}

impl RowBarrier {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            gradient: [Lanes::default(); 3],
            from: 0,
            end: 0,
            first_block: 0,
            end_block: 0,
            penalty: None,
            blocks: vec![Block::default(); max_horizon / WIDTH + 1],
        }
    }

    /// Starts with the slacks that the states leave, at least `least`, and products of about `mu`.
    pub(super) fn start(
        &mut self,
        row: &Row,
        limits: &[f64],
        states: &[[f64; 3]],
        least: f64,
        mu: f64,
    ) {
        self.gradient = row.gradient.map(Lanes::all);
        self.from = row.from;
        self.end = row.from.max(row.to + 1);
        let is_off = self.from == self.end;
        (self.first_block, self.end_block) =
            if is_off { (0, 0) } else { (self.from / WIDTH, self.end.div_ceil(WIDTH)) };
        self.penalty = match row.softness {
            Softness::Hard => None,
            Softness::Soft { linear, quadratic } => Some((linear, quadratic)),
        };
        for k in WIDTH * self.first_block..WIDTH * self.end_block {
            let is_in_force = (self.from..self.end).contains(&k);
            let limit = if is_in_force { within_reach(limits[k]) } else { NO_LIMIT };
            let room = if is_in_force { limit - dot(&row.gradient, &states[k]) } else { limit };
            let (j, lane) = place(k);
            let block = &mut self.blocks[j];
            block.limit.0[lane] = limit;
            block.is_in_force.0[lane] = f64::from(u8::from(is_in_force));
            let s = room.max(least);
            block.below.set(lane, s, mu / s);
            if let Some((penalty, curvature)) = self.penalty {
                let m = (mu / s).min(0.5 * penalty);
                block.below.set(lane, s, m);
                let sigma = (s - room).max(least);
                block.violation.set(lane, sigma, penalty + curvature * sigma - m);
            }
        }
    }

    /// Returns the number of pairs.
    pub(super) fn pairs(&self) -> usize {
        let families = if self.penalty.is_some() { 2 } else { 1 };
        families * WIDTH * (self.end_block - self.first_block)
    }

    #[inline(always)]
    fn block(&mut self, j: usize) -> Option<&mut Block> {
        self.blocks[..self.end_block].get_mut(j).filter(|_| j >= self.first_block)
    }

    /// Models the pairs of a block for the predictor; returns the sum of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, x: &[Lanes; 3], model: &mut BlockModel) -> Lanes {
        let (gradient, penalty) = (self.gradient, self.penalty);
        let Some(block) = self.block(j) else { return Lanes::default() };
        let mut gap = block.below.invert();
        let Pairs { slack: s, multiplier: m, per_multiplier, .. } = block.below;
        // First s + (residual of the slack).
        let mut offset = block.limit - product(&gradient, x);
        let mut compliance = s * per_multiplier + Lanes::all(PROXIMAL);
        if let Some((weight, curvature)) = penalty {
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
        model.add(&gradient, block.is_in_force * w, block.is_in_force * block.slope);
        gap
    }

    /// Applies the predictor's changes of a block's states.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, dx: &[Lanes; 3], prediction: &mut Prediction) {
        let (gradient, is_soft) = (self.gradient, self.penalty.is_some());
        let Some(block) = self.block(j) else { return };
        let dm = block.curvature * (product(&gradient, dx) - block.offset);
        let below = &mut block.below;
        below.predict(-(dm * below.per_multiplier) - ONE, prediction);
        if is_soft {
            let violation = &mut block.violation;
            let r = (dm - block.price) * block.per_stiffness;
            violation.predict(r, prediction);
        }
    }

    /// Sets the corrector's targets of a block, and adds their term to the gradient.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets, added: &mut [Lanes; 3]) {
        let (gradient, is_soft) = (self.gradient, self.penalty.is_some());
        let Some(block) = self.block(j) else { return };
        let below = &mut block.below;
        below.set_targets(targets);
        let mut moved = below.target * below.per_multiplier;
        if is_soft {
            block.violation.set_targets(targets);
            moved = moved - block.violation.target * block.per_stiffness;
        }
        block.slope = block.curvature * moved;
        add_slope(added, &gradient, block.slope);
    }

    /// Applies the step's changes of a block's states.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, dx: &[Lanes; 3], limits: &mut Limits) {
        let (gradient, is_soft) = (self.gradient, self.penalty.is_some());
        let Some(block) = self.block(j) else { return };
        let dm = block.curvature * (product(&gradient, dx) - block.offset) + block.slope;
        let below = &mut block.below;
        let r = (below.target * below.per_slack - dm) * below.per_multiplier - ONE;
        below.correct(r, limits);
        if is_soft {
            let violation = &mut block.violation;
            let pull = violation.target * violation.per_slack - block.price + dm;
            violation.correct(pull * block.per_stiffness, limits);
        }
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, lengths: Lengths) {
        let is_soft = self.penalty.is_some();
        let Some(block) = self.block(j) else { return };
        block.below.advance(lengths);
        if is_soft {
            block.violation.advance(lengths);
        }
    }

    /// Writes the parts of the row's graph that the stages approach.
    pub(super) fn suggest(&self, stiffness: f64, tangents: &mut [RowTangent]) {
        tangents.fill(RowTangent::default());
        for j in self.first_block..self.end_block {
            let Block { below, violation, .. } = &self.blocks[j];
            let (acts, is_kept) = (below.are_active(), violation.are_active());
            let first = WIDTH * j;
            for k in first.max(self.from)..(first + WIDTH).min(self.end) {
                let lane = k - first;
                tangents[k] = match self.penalty {
                    _ if !acts[lane] => continue,
                    Some((penalty, curvature)) if !is_kept[lane] => {
                        RowTangent::beyond(penalty, curvature)
                    }
                    _ => RowTangent::edge(below.multiplier.0[lane], stiffness),
                };
            }
        }
    }

    /// Returns the largest multiplier.
    pub(super) fn largest_multiplier(&self) -> f64 {
        let blocks = &self.blocks[self.first_block..self.end_block];
        blocks
            .iter()
            .fold(Lanes::default(), |top, block| block.below.multiplier.greater(top))
            .largest()
    }

    /// Copies the multipliers of its stages to `multipliers`.
    pub(super) fn read(&self, multipliers: &mut [f64]) {
        for k in self.from..self.end {
            let (j, lane) = place(k);
            multipliers[k] = self.blocks[j].below.multiplier.0[lane];
        }
    }
}

/// Returns a finite limit: no cruise state comes near [`NO_LIMIT`], which replaces larger ones.
fn within_reach(limit: f64) -> f64 {
    if limit < NO_LIMIT { limit } else { NO_LIMIT }
}
