//! The road in the plane, between `s`, `t` and coordinates.
//!
//! The plane has its origin at the start of the first road's reference line, and its x axis along it there. A road through
//! junctions is cut into legs, since the line of a way through a junction may begin beside the one before it:
//!
//! ```text
//! first road      ─────────────┐ cut
//! way through it               └──────────╮ cut    `t` goes on without a jump
//! ```

use road::{Axis, AxisError, Laid, Leg, MIN_RADIUS_M, Piece, Pose};
use serde::{Deserialize, Serialize};

use super::Road;

/// Smallest radius of a line through junctions, m.
pub const NARROW_RADIUS_M: f64 = 3.0;

/// The place where a leg begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// Its first piece.
    pub piece: usize,
    pub from_m: f64,
    /// The leg's line is that far to the left of the road's, m.
    pub shift_m: f64,
}

/// The legs of a line in a plane whose origin is given in the coordinates of the file.
pub fn legs(pieces: &[Laid], cuts: &[Cut], plane: &Pose) -> Result<Vec<Leg>, AxisError> {
    let line = [Laid { start: *plane, piece: Piece::Line { length_m: 1.0 } }];
    let pieces = if pieces.is_empty() { &line } else { pieces };
    let whole = [Cut::default()];
    let begins = if cuts.is_empty() { &whole } else { cuts };
    let least_m = if cuts.is_empty() { MIN_RADIUS_M } else { NARROW_RADIUS_M };
    let leg = |(number, cut): (usize, &Cut)| {
        let end = begins.get(number + 1).map_or(pieces.len(), |next| next.piece);
        let own = pieces.get(cut.piece..end).unwrap_or_default();
        let axis = Axis::laid(own, least_m)?;
        let start = own[0].start.seen_from(plane);
        Ok(Leg { axis, start, from_m: cut.from_m, shift_m: cut.shift_m })
    };
    begins.iter().enumerate().map(leg).collect()
}

#[derive(Clone, Debug)]
pub(crate) struct Ground {
    pub legs: Vec<Leg>,
    /// The origin of the plane in the coordinates of the file.
    pub plane: Pose,
}

impl Ground {
    pub fn of(road: &Road, plane: &Pose) -> Result<Self, AxisError> {
        Ok(Self { legs: legs(&road.pieces, &road.cuts, plane)?, plane: *plane })
    }

    fn number(&self, s_m: f64) -> usize {
        self.legs.partition_point(|leg| leg.from_m <= s_m).max(1) - 1
    }

    /// The direction of the reference line, rad.
    pub fn direction_rad(&self, s_m: f64) -> f64 {
        let leg = &self.legs[self.number(s_m)];
        leg.start.heading_rad + leg.axis.pose(s_m - leg.from_m).heading_rad
    }

    /// A point of the road with the direction of the reference line.
    pub fn point(&self, s_m: f64, t_m: f64) -> Pose {
        let leg = &self.legs[self.number(s_m)];
        leg.axis.point(s_m - leg.from_m, t_m - leg.shift_m).placed(&leg.start)
    }

    /// `s` and `t` of a point of the plane near a place, m.
    pub fn project(&self, (x_m, y_m): (f64, f64), near_s_m: f64) -> (f64, f64) {
        let (mut number, mut place) = (self.number(near_s_m), (near_s_m, 0.0));
        for _ in &self.legs {
            let leg = &self.legs[number];
            let (x_m, y_m) = leg.start.to_local(x_m, y_m);
            let (p_m, l_m) = leg.axis.project(x_m, y_m, place.0 - leg.from_m);
            place = (leg.from_m + p_m, leg.shift_m + l_m);
            let there = self.number(place.0);
            if there == number {
                break;
            }
            number = if there > number { number + 1 } else { number - 1 };
        }
        place
    }

    /// Metres of way for one metre of `s` at a distance from the reference line; not less than a tenth.
    pub fn stretch(&self, s_m: f64, t_m: f64) -> f64 {
        let leg = &self.legs[self.number(s_m)];
        (1.0 - leg.axis.curvature_perm(s_m - leg.from_m) * (t_m - leg.shift_m)).max(0.1)
    }
}
