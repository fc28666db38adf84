//! Upper and lower bounds of all inputs.

use super::pairs::{Pairs, Prediction, Targets, place};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::BlockModel;
use crate::riccati::working_set::Side;

/// Inputs of a block of stages with their pairs `(u − u_min, λ_l)` and `(u_max − u, λ_u)`.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    u: Lanes,
    lower: Pairs,
    upper: Pairs,
}

/// Inputs in blocks; lanes of the last block beyond the horizon have no effect.
#[derive(Clone, Debug)]
pub(super) struct InputBarrier {
    blocks: Vec<Block>,
    /// Number of blocks in use.
    count: usize,
}

impl InputBarrier {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self { blocks: vec![Block::default(); max_horizon.div_ceil(WIDTH)], count: 0 }
    }

    /// Starts at `inputs`, at least `margin` (of the range) away from the bounds, with products
    /// `mu`.
    pub(super) fn start(&mut self, inputs: &[f64], (lo, hi): (f64, f64), margin: f64, mu: f64) {
        self.count = inputs.len().div_ceil(WIDTH);
        let room = margin * (hi - lo);
        let middle = 0.5 * (lo + hi);
        for k in 0..WIDTH * self.count {
            let u = inputs.get(k).map_or(middle, |u| u.max(lo + room).min(hi - room));
            let (j, lane) = place(k);
            let block = &mut self.blocks[j];
            block.u.0[lane] = u;
            block.lower.set(lane, u - lo, mu / (u - lo));
            block.upper.set(lane, hi - u, mu / (hi - u));
        }
    }

    pub(super) fn pairs(&self) -> usize {
        2 * WIDTH * self.count
    }

    #[inline(always)]
    pub(super) fn value(&self, k: usize) -> f64 {
        let (j, lane) = place(k);
        self.blocks[j].u.0[lane]
    }

    /// Models the pairs of a block for the predictor; returns the sum of the products.
    ///
    /// With `t = 0` the new multipliers leave only `W du`: the slope is 0.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, model: &mut BlockModel) -> Lanes {
        let Some(Block { lower, upper, .. }) = self.blocks[..self.count].get_mut(j) else {
            return Lanes::default();
        };
        let gap = lower.invert() + upper.invert();
        model.curvature = lower.multiplier * lower.per_slack + upper.multiplier * upper.per_slack;
        gap
    }

    /// Applies the predictor's changes of a block's inputs.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, du: Lanes, prediction: &mut Prediction) {
        let Some(Block { lower, upper, .. }) = self.blocks[..self.count].get_mut(j) else { return };
        lower.predict(du * lower.per_slack, prediction);
        upper.predict(-(du * upper.per_slack), prediction);
    }

    /// Sets the corrector's targets of a block; returns their term in the gradient of its inputs.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets) -> Lanes {
        let Some(Block { lower, upper, .. }) = self.blocks[..self.count].get_mut(j) else {
            return Lanes::default();
        };
        lower.set_targets(targets);
        upper.set_targets(targets);
        upper.target * upper.per_slack - lower.target * lower.per_slack
    }

    /// Applies the step's changes of a block's inputs.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, du: Lanes, limit: &mut Lanes) {
        let Some(Block { lower, upper, .. }) = self.blocks[..self.count].get_mut(j) else { return };
        lower.correct(du * lower.per_slack, limit);
        upper.correct(-(du * upper.per_slack), limit);
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, du: Lanes, length: f64) {
        let Some(block) = self.blocks[..self.count].get_mut(j) else { return };
        block.lower.advance(length);
        block.upper.advance(length);
        block.u = block.u + Lanes::all(length) * du;
    }

    /// Returns the bounds that the inputs of a block approach.
    pub(super) fn sides(&self, j: usize) -> [Side; WIDTH] {
        let (upper, lower) = (self.blocks[j].upper.are_active(), self.blocks[j].lower.are_active());
        std::array::from_fn(|lane| match (upper[lane], lower[lane]) {
            (true, _) => Side::Upper,
            (false, true) => Side::Lower,
            (false, false) => Side::Free,
        })
    }
}
