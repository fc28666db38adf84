//! The cells of an axis.

use crate::cell::{CELL_M, Cell, after};
use crate::smooth::{Smooth, State};
use crate::{AxisError, AxisFault, MIN_RADIUS_M, Pose};

/// Largest number of halvings of a cell: 5 m / 2^8 is 2 cm.
const MAX_HALVINGS: u32 = 8;
/// Most cells of an axis.
const MAX_CELLS: usize = 1 << 20;
/// A radius that is smaller by rounding alone is accepted.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Adds cells, piece after piece.
pub struct Builder {
    pub cells: Vec<Cell>,
    /// End of the pieces so far, m.
    pub length_m: f64,
    pub min_radius_m: f64,
    /// Cells of lines, arcs and clothoids are halved where the series misses their ends.
    pub halves: bool,
}

/// The piece that is being added.
struct Piece<'a> {
    smooth: &'a dyn Smooth,
    number: usize,
    start: Pose,
    from_m: f64,
    min_radius_m: f64,
}

impl Piece<'_> {
    /// A cell with the middle `state`, up to `end_m` of the piece.
    fn cell(&self, state: &State, end_m: f64) -> Cell {
        let pose = state.pose.placed(&self.start);
        let (sin, cos) = libm::sincos(pose.heading_rad);
        Cell {
            end_m: self.from_m + end_m,
            middle_m: self.from_m + state.q_m,
            pose,
            cos,
            sin,
            curvature_perm: state.curvature_perm,
            rate_perm2: state.rate_perm2,
            pace: self.smooth.pace(),
        }
    }

    fn check(&self, state: &State) -> Result<(), AxisError> {
        if !state.pose.is_finite()
            || !state.curvature_perm.is_finite()
            || !state.rate_perm2.is_finite()
        {
            return Err(AxisFault::Cusp.of(self.number));
        }
        if state.curvature_perm.abs() * self.min_radius_m > ROUNDING {
            let radius_m = 1.0 / state.curvature_perm.abs();
            return Err(AxisFault::Radius(radius_m).of(self.number));
        }
        Ok(())
    }
}

impl Builder {
    /// No piece yet, for a road of the usual radii.
    pub fn new() -> Self {
        Self { cells: Vec::new(), length_m: 0.0, min_radius_m: MIN_RADIUS_M, halves: false }
    }

    /// Adds a piece that begins at `start`. Returns its end.
    pub fn add(
        &mut self,
        smooth: &dyn Smooth,
        number: usize,
        start: Pose,
    ) -> Result<Pose, AxisError> {
        let length_m = smooth.length_m();
        let (from_m, min_radius_m) = (self.length_m, self.min_radius_m);
        let piece = Piece { smooth, number, start, from_m, min_radius_m };
        let count = libm::ceil(length_m / CELL_M - 1e-9).max(1.0);
        let mut state = smooth.begin();
        piece.check(&state)?;
        for i in 1..=count as u64 {
            let share = i as f64 / count;
            let end_m = if share < 1.0 { length_m * share } else { length_m };
            state = self.part(&piece, &state, end_m, 0)?;
        }
        self.length_m += length_m;
        Ok(state.pose.placed(&start))
    }

    /// Adds the cells from `state` to `end_m`. Returns the state there.
    fn part(
        &mut self,
        piece: &Piece<'_>,
        state: &State,
        end_m: f64,
        halvings: u32,
    ) -> Result<State, AxisError> {
        let middle = piece.smooth.advance(state, 0.5 * (state.q_m + end_m));
        let end = piece.smooth.advance(&middle, end_m);
        piece.check(&middle)?;
        piece.check(&end)?;
        let cell = piece.cell(&middle, end_m);
        let misses = |state: &State| {
            let (exact, near) =
                (state.pose.placed(&piece.start), cell.at(piece.from_m + state.q_m));
            let (max_m, max_rad) = piece.smooth.tolerance();
            libm::hypot(exact.x_m - near.x_m, exact.y_m - near.y_m) > max_m
                || (exact.heading_rad - near.heading_rad).abs() > max_rad
        };
        if (self.halves || !piece.smooth.is_clothoid()) && (misses(state) || misses(&end)) {
            if halvings == MAX_HALVINGS {
                return Err(AxisFault::Cusp.of(piece.number));
            }
            self.part(piece, state, middle.q_m, halvings + 1)?;
            return self.part(piece, &middle, end_m, halvings + 1);
        }
        if self.cells.len() == MAX_CELLS {
            return Err(AxisFault::Cusp.of(piece.number));
        }
        self.cells.push(cell);
        Ok(end)
    }

    /// For each 5 m the first cell that reaches beyond its beginning.
    pub fn bins(&self) -> Vec<u32> {
        let count = after(self.length_m) + 1;
        let mut cell = 0;
        (0..count)
            .map(|bin| {
                while cell + 1 < self.cells.len() && self.cells[cell].end_m <= CELL_M * bin as f64 {
                    cell += 1;
                }
                cell as u32
            })
            .collect()
    }
}
