//! The axis of a road.

use crate::build::Builder;
use crate::cell::{CELL_M, Cell, Place, after};
use crate::{
    AxisError, AxisFault, CROSSING_WITHIN_M, Laid, MAX_GAP_M, MAX_KINK_RAD, MAX_LENGTH_M,
    MIN_RADIUS_M, Piece, Pose,
};

/// Most steps of a projection; three are usual.
const MAX_STEPS: u32 = 40;
const LONGEST_STEP_M: f64 = 20.0;
/// Distances that differ by less than this are the same, m.
const SAME_M: f64 = 1e-6;
/// A step that ends a projection, m.
const LAST_STEP_M: f64 = 1e-9;
/// Least rate at which the foot of a point moves: beyond the centre of a curve there is no foot.
const MIN_RATE: f64 = 0.1;
/// A line whose start differs by less than this from the straight beginning goes on with it, m and rad.
const STRAIGHT: f64 = 1e-9;
/// Length of the chords that stand for the axis, m.
const CHORD_M: f64 = 5.0;

/// The axis of a road. It begins at (0, 0, 0) and goes on straight outside its ends.
///
/// ```
/// use road::{Axis, Piece};
/// let axis = Axis::new(&[Piece::Arc { length_m: 100.0, curvature_perm: 0.01 }])?;
/// let end = axis.pose(100.0);
/// assert!((end.heading_rad - 1.0).abs() < 1e-12 && (end.x_m - 100.0 * 1_f64.sin()).abs() < 1e-8);
/// # Ok::<(), road::AxisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Axis {
    bins: Vec<u32>,
    cells: Vec<Cell>,
    length_m: f64,
    /// Beginnings of its pieces, m.
    pub(crate) starts: Vec<f64>,
    /// Up to here `p` is `x`.
    straight_m: f64,
    /// The straight behind the end.
    beyond: Cell,
}

impl Axis {
    /// A chain of pieces, each from the end of the one before.
    ///
    /// # Errors
    /// If a number is not finite, a length is not positive, a radius is below 20 m, or the chain crosses itself.
    pub fn new(pieces: &[Piece]) -> Result<Self, AxisError> {
        Self::chain(pieces.iter().map(|piece| (None, *piece)), MIN_RADIUS_M)
    }

    /// The way of a vehicle through junctions. Its turns are narrow, and it may cross itself. Short pieces keep it exact:
    /// a cell of 5 m is too long for a radius of a few metres.
    ///
    /// # Errors
    /// As [`Self::new`], with another smallest radius.
    pub fn narrow(pieces: &[Piece], min_radius_m: f64) -> Result<Self, AxisError> {
        Self::chain(pieces.iter().map(|piece| (None, *piece)), min_radius_m)
    }

    /// Pieces with places of their own. The axis begins at (0, 0, 0): the first piece's start is its origin.
    ///
    /// # Errors
    /// As [`Self::new`], and if a piece does not begin where the previous one ends, within 5 cm and 0.01 rad.
    pub fn laid(pieces: &[Laid], min_radius_m: f64) -> Result<Self, AxisError> {
        let origin = pieces.first().map_or(Pose::default(), |laid| laid.start);
        let laid = pieces.iter().map(|laid| (Some(laid.start.seen_from(&origin)), laid.piece));
        Self::chain(laid, min_radius_m)
    }

    fn chain(
        pieces: impl ExactSizeIterator<Item = (Option<Pose>, Piece)>,
        min_radius_m: f64,
    ) -> Result<Self, AxisError> {
        if pieces.len() == 0 {
            return Err(AxisFault::Empty.of(0));
        }
        let mut builder = Builder { min_radius_m, ..Builder::new() };
        let (mut end, mut straight_m) = (Pose::default(), 0.0);
        let mut starts = Vec::with_capacity(pieces.len());
        for (number, (start, piece)) in pieces.enumerate() {
            piece.check(number)?;
            let length_m = builder.length_m + piece.length_m();
            if length_m > MAX_LENGTH_M {
                return Err(AxisFault::Length(length_m).of(number));
            }
            builder.halves = start.is_some() && min_radius_m < MIN_RADIUS_M;
            let start = match start {
                Some(start) => joined(&start, &end, number, MAX_KINK_RAD)?,
                None => end,
            };
            let is_line = matches!(piece, Piece::Line { .. });
            if is_line && straight_m == builder.length_m && goes_on(&start, straight_m) {
                straight_m = length_m;
            }
            starts.push(builder.length_m);
            end = builder.add(&*piece.smooth(), number, start)?;
        }
        Self::of(builder, starts, end, straight_m)
    }

    /// The axis of what was built, with where its pieces begin, its end, and how long it is straight.
    pub(crate) fn of(
        builder: Builder,
        starts: Vec<f64>,
        end: Pose,
        straight_m: f64,
    ) -> Result<Self, AxisError> {
        let (sin, cos) = libm::sincos(end.heading_rad);
        let (length_m, is_narrow) = (builder.length_m, builder.min_radius_m < MIN_RADIUS_M);
        let beyond = Cell {
            end_m: f64::INFINITY,
            middle_m: length_m,
            pose: end,
            cos,
            sin,
            curvature_perm: 0.0,
            rate_perm2: 0.0,
            pace: 1.0,
        };
        let axis = Self {
            bins: builder.bins(),
            cells: builder.cells,
            length_m,
            starts,
            straight_m: if straight_m == length_m { f64::INFINITY } else { straight_m },
            beyond,
        };
        if !axis.is_straight() && !is_narrow {
            uncrossed(axis.length_m(), &axis.starts, |p_m| axis.pose(p_m))?;
        }
        Ok(axis)
    }

    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    pub fn is_straight(&self) -> bool {
        self.straight_m == f64::INFINITY
    }

    /// The cell of a place behind the straight beginning.
    #[inline]
    fn cell(&self, p_m: f64) -> &Cell {
        if !(p_m < self.length_m) {
            return &self.beyond;
        }
        let mut index = self.bins[after(p_m)] as usize;
        while self.cells[index].end_m <= p_m && index + 1 < self.cells.len() {
            index += 1;
        }
        &self.cells[index]
    }

    #[inline]
    pub(crate) fn place(&self, p_m: f64) -> Place {
        if p_m <= self.straight_m {
            let (heading_rad, curvature_perm) = (0.0, 0.0);
            return Place { x_m: p_m, y_m: 0.0, heading_rad, cos: 1.0, sin: 0.0, curvature_perm };
        }
        self.cell(p_m).at(p_m)
    }

    /// The pose of the axis itself. The heading is not wrapped: it goes on along the axis.
    pub fn pose(&self, p_m: f64) -> Pose {
        let place = self.place(p_m);
        Pose { x_m: place.x_m, y_m: place.y_m, heading_rad: place.heading_rad }
    }

    /// The point `l_m` to the left of the axis, with the heading of the tangent.
    pub fn point(&self, p_m: f64, l_m: f64) -> Pose {
        let Place { x_m, y_m, heading_rad, .. } = self.frame(p_m, l_m);
        Pose { x_m, y_m, heading_rad }
    }

    /// The same with the direction and the curvature of the axis there.
    pub fn frame(&self, p_m: f64, l_m: f64) -> Place {
        let place = self.place(p_m);
        Place { x_m: place.x_m - l_m * place.sin, y_m: place.y_m + l_m * place.cos, ..place }
    }

    /// The curvature, 1/m: positive to the left, 0 outside the ends.
    pub fn curvature_perm(&self, p_m: f64) -> f64 {
        if p_m <= self.straight_m { 0.0 } else { self.cell(p_m).curvature_at(p_m) }
    }

    /// The heading of the tangent, rad, as in [`Self::pose`].
    pub fn heading_rad(&self, p_m: f64) -> f64 {
        if p_m <= self.straight_m { 0.0 } else { self.cell(p_m).heading_at(p_m) }
    }

    /// The change of the curvature along the axis, 1/m².
    pub fn curvature_rate_perm2(&self, p_m: f64) -> f64 {
        if p_m <= self.straight_m { 0.0 } else { self.cell(p_m).rate_perm2 }
    }

    /// Metres along the curve for one metre of `p`: not 1 where a cubic has another length than declared.
    pub(crate) fn pace(&self, p_m: f64) -> f64 {
        if p_m <= self.straight_m { 1.0 } else { self.cell(p_m).pace }
    }

    /// The coordinates (p, l) of a point: Newton's method from `near_p_m`, which must lie on the point's branch.
    ///
    /// A point has a foot on the axis as far as the centre of the curve. Beyond it the result is of no use.
    pub fn project(&self, x_m: f64, y_m: f64, near_p_m: f64) -> (f64, f64) {
        let (mut p_m, mut reach_m) = (near_p_m, LONGEST_STEP_M);
        for _ in 0..MAX_STEPS {
            if p_m <= self.straight_m {
                if x_m <= self.straight_m {
                    return (x_m, y_m);
                }
                // The straight beginning ends here: at its joint the curve takes over.
                p_m = x_m.min(self.straight_m + reach_m);
                reach_m *= 0.5;
                continue;
            }
            let cell = self.cell(p_m);
            let place = cell.at(p_m);
            let (dx_m, dy_m) = (x_m - place.x_m, y_m - place.y_m);
            let along_m = dx_m * place.cos + dy_m * place.sin;
            let left_m = dy_m * place.cos - dx_m * place.sin;
            let rate = cell.pace * (1.0 - place.curvature_perm * left_m).max(MIN_RATE);
            let step_m = (along_m / rate).clamp(-LONGEST_STEP_M, LONGEST_STEP_M);
            p_m += step_m;
            if step_m.abs() < LAST_STEP_M {
                break;
            }
        }
        let place = self.place(p_m);
        (p_m, (y_m - place.y_m) * place.cos - (x_m - place.x_m) * place.sin)
    }

    /// The coordinates (p, l) of the axis' point that is nearest to a point of the plane. The search has no place to
    /// begin from. It is the first of several branches that are equally near.
    pub fn nearest(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let count = self.bins.len();
        let start_m = |i: usize| (CELL_M * i as f64).min(self.length_m);
        let way_m = |i: usize| {
            let place = self.place(start_m(i));
            libm::hypot(x_m - place.x_m, y_m - place.y_m)
        };
        let least_m = (0..=count).map(way_m).fold(f64::INFINITY, f64::min);
        let (mut best, mut before_m) = (None::<(f64, f64)>, f64::INFINITY);
        for i in 0..=count {
            let here_m = way_m(i);
            let is_low = here_m <= before_m && (i == count || here_m <= way_m(i + 1));
            before_m = here_m;
            if is_low && here_m <= least_m + CELL_M {
                let found = self.project(x_m, y_m, start_m(i));
                if best.is_none_or(|best| found.1.abs() < best.1.abs() - SAME_M) {
                    best = Some(found);
                }
            }
        }
        best.unwrap_or_else(|| self.project(x_m, y_m, 0.0))
    }
}

/// True if a line from `start` goes on with a straight beginning of that length.
pub(crate) fn goes_on(start: &Pose, straight_m: f64) -> bool {
    let [x_m, y_m, heading_rad] = [start.x_m - straight_m, start.y_m, start.heading_rad];
    x_m.abs() < STRAIGHT && y_m.abs() < STRAIGHT && heading_rad.abs() < STRAIGHT
}

/// The start of a piece that is laid, with a heading that goes on from the end before.
pub(crate) fn joined(
    start: &Pose,
    end: &Pose,
    piece: usize,
    max_kink_rad: f64,
) -> Result<Pose, AxisError> {
    if !start.is_finite() {
        return Err(AxisFault::NotFinite.of(piece));
    }
    let gap_m = libm::hypot(start.x_m - end.x_m, start.y_m - end.y_m);
    if gap_m > MAX_GAP_M {
        return Err(AxisFault::Gap(gap_m).of(piece));
    }
    let turn = start.heading_rad - end.heading_rad;
    let kink_rad = libm::remainder(turn, std::f64::consts::TAU);
    if kink_rad.abs() > max_kink_rad {
        return Err(AxisFault::Kink(kink_rad).of(piece));
    }
    Ok(Pose { heading_rad: end.heading_rad + kink_rad, ..*start })
}

/// Checks that branches near each other along an axis of `length_m` do not cross. Its pieces begin at `starts`.
fn uncrossed(length_m: f64, starts: &[f64], pose: impl Fn(f64) -> Pose) -> Result<(), AxisError> {
    let chords = libm::ceil(length_m / CHORD_M) as usize;
    let window = (CROSSING_WITHIN_M / CHORD_M) as usize;
    let at = |i: usize| pose((CHORD_M * i as f64).min(length_m));
    let poses: Vec<_> = (0..=chords).map(at).collect();
    for i in 0..chords {
        let (mut least, mut most) = (poses[i].heading_rad, poses[i].heading_rad);
        for j in i + 1..chords.min(i + window + 1) {
            for pose in &poses[j..=j + 1] {
                least = least.min(pose.heading_rad);
                most = most.max(pose.heading_rad);
            }
            // A curve that turns by less than half a circle cannot meet itself.
            if most - least < std::f64::consts::PI || j == i + 1 {
                continue;
            }
            let ends = [&poses[i], &poses[i + 1], &poses[j], &poses[j + 1]].map(|p| (p.x_m, p.y_m));
            if cross(ends) {
                let (first_m, second_m) = (CHORD_M * i as f64, CHORD_M * j as f64);
                let begun = starts.partition_point(|start| *start <= second_m);
                let piece = begun.saturating_sub(1);
                return Err(AxisFault::Crossing { first_m, second_m }.of(piece));
            }
        }
    }
    Ok(())
}

/// True if the chords `a b` and `c d` cross.
fn cross([a, b, c, d]: [(f64, f64); 4]) -> bool {
    let side = |p: (f64, f64), q: (f64, f64), r: (f64, f64)| {
        (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)
    };
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}
