//! Trajectories in blocks of stages, component by component. The sweeps fill them stage by stage;
//! the pairs read them lane by lane.

use super::pairs::place;
use crate::riccati::lanes::{Lanes, WIDTH};

/// Inputs and states of [`WIDTH`] stages, or their changes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathBlock {
    pub(super) u: Lanes,
    pub(super) x: [Lanes; 3],
}

impl PathBlock {
    /// Sets the state of a stage.
    #[inline(always)]
    pub(super) fn set_state(&mut self, lane: usize, x: &[f64; 3]) {
        for i in 0..3 {
            self.x[i].0[lane] = x[i];
        }
    }

    /// Adds another trajectory's block.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.u = self.u + other.u;
        for i in 0..3 {
            self.x[i] = self.x[i] + other.x[i];
        }
    }
}

/// Returns a zero trajectory with room for `max_horizon` steps.
pub(super) fn path(max_horizon: usize) -> Vec<PathBlock> {
    vec![PathBlock::default(); max_horizon / WIDTH + 1]
}

/// Returns `x_k`.
pub(super) fn state(path: &[PathBlock], k: usize) -> [f64; 3] {
    let (j, lane) = place(k);
    path[j].x.map(|lanes| lanes.0[lane])
}

/// Returns the block of `values` that begins at an entry.
#[inline(always)]
pub(super) fn block<T>(values: &[T], first: usize) -> &[T; WIDTH] {
    values[first..].first_chunk().expect("there is room for whole blocks")
}

/// As [`block`], to be changed.
#[inline(always)]
pub(super) fn block_mut<T>(values: &mut [T], first: usize) -> &mut [T; WIDTH] {
    values[first..].first_chunk_mut().expect("there is room for whole blocks")
}
