//! The iterate as a model of the stages, a block at a time: the cost, and each eliminated pair.

use super::barriers::Barriers;
use super::path::PathBlock;
use crate::riccati::lanes::Lanes;
use crate::riccati::lqr::{BlockModel, BlockModels, Cost};

/// The iterate as models of the stages.
pub(super) struct Models<'a> {
    pub(super) r: f64,
    pub(super) barriers: &'a mut Barriers,
    pub(super) cost: &'a Cost,
    pub(super) iterate: &'a [PathBlock],
    /// Sum of the products of the pairs so far.
    pub(super) gap: Lanes,
}

impl BlockModels for Models<'_> {
    const IS_WHOLE: bool = false;

    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        let PathBlock { u, x } = &self.iterate[j];
        let mut model = self.cost.block_at(j, self.r, *u, x);
        self.gap = self.gap + self.barriers.linearize(j, x, &mut model);
        model
    }
}
