//! A curve to go along, and a place on it.

use crate::Pose;

/// A place on a piece, in axes that begin with the piece.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    /// Along the piece, m.
    pub q_m: f64,
    pub pose: Pose,
    pub curvature_perm: f64,
    /// Change of the curvature along the curve, 1/m².
    pub rate_perm2: f64,
    /// The piece's own parameter.
    pub parameter: f64,
}

/// Something smooth to go along.
pub(crate) trait Smooth {
    /// Its length in `q`, m.
    fn length_m(&self) -> f64;
    /// Its beginning.
    fn begin(&self) -> State;
    /// The place at `q_m`, at most a cell from another one.
    fn advance(&self, from: &State, q_m: f64) -> State;
    /// Metres along the curve for one metre of `q`.
    fn pace(&self) -> f64 {
        1.0
    }
    /// Largest error of a cell's series at its ends, m and rad. One axis beside another takes more than this one.
    fn tolerance(&self) -> (f64, f64) {
        (1e-7, 5e-8)
    }
    /// True if the curvature changes evenly.
    fn is_clothoid(&self) -> bool {
        false
    }
}
