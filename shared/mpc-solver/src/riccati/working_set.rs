//! Guess of the active set: the bounds of the inputs, and the parts of the curves of light and rows.
//!
//! The active-set method improves it from round to round, and the interior point derives one from
//! its iterate.

use super::curve::{STIFFNESS, Tangent};
use crate::limits::MAX_ROWS;

/// Bound at which an input is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i8)]
pub(super) enum Side {
    /// `u_min`.
    Lower = -1,
    #[default]
    Free = 0,
    /// `u_max`.
    Upper = 1,
}

/// Guess, stage by stage.
#[derive(Clone, Debug)]
pub(super) struct WorkingSet {
    /// `sides[k]` belongs to `u_k`.
    pub(super) sides: Vec<Side>,
    /// `light[k]` belongs to stage `k`.
    pub(super) light: Vec<Tangent>,
    /// `rows[j][k]` belongs to stage `k`; a cold attempt does not use them.
    pub(super) rows: [Vec<Tangent>; MAX_ROWS],
    /// Slope of the rows' tangents at their limits.
    pub(super) row_stiffness: f64,
}

impl WorkingSet {
    /// Returns a guess with all inputs free and room for horizons up to `max_horizon`.
    pub(super) fn new(max_horizon: usize) -> Self {
        let tangents = || vec![Tangent::default(); max_horizon + 1];
        Self {
            sides: vec![Side::Free; max_horizon],
            light: tangents(),
            rows: std::array::from_fn(|_| tangents()),
            row_stiffness: STIFFNESS,
        }
    }
}
