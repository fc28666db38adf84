//! The pieces of a plan.

use scenario_derive::tables;

use crate::Problem;
use crate::quantity::{CurveRadius, PieceLength};

tables! {
    /// A piece of the road: `{ line_m }`, `{ spiral_m }` or `{ arc_m, radius_m, turn }`. A spiral is a clothoid that
    /// joins the curvatures of its neighbours.
    #[derive(Copy)]
    pub struct PlanPiece {
        /// Length of a straight line, m.
        pub line_m: Option<PieceLength>,
        /// Length of a circular arc, m.
        pub arc_m: Option<PieceLength>,
        /// Length of a clothoid, m.
        pub spiral_m: Option<PieceLength>,
        /// Radius of an arc, m.
        pub radius_m: Option<CurveRadius>,
        /// Side to which an arc turns.
        pub turn: Option<Turn>,
    }

    /// Side to which an arc turns.
    pub enum Turn {
        /// To the left.
        Left,
        /// To the right.
        Right,
    }
}

/// The right forms of a piece.
const FORMS: &str = "{ line_m }, { spiral_m } or { arc_m, radius_m, turn }";

impl PlanPiece {
    /// The piece of the geometry; a spiral of curvatures 0, which it takes from its neighbours.
    fn alone(&self) -> Option<road::Piece> {
        let Self { line_m, arc_m, spiral_m, radius_m, turn } = *self;
        let [line_m, arc_m, spiral_m] =
            [line_m, arc_m, spiral_m].map(|l| l.map(PieceLength::value));
        Some(match (line_m, spiral_m, (arc_m, radius_m, turn)) {
            (Some(length_m), None, (None, None, None)) => road::Piece::Line { length_m },
            (None, Some(length_m), (None, None, None)) => {
                road::Piece::Spiral { length_m, start_perm: 0.0, end_perm: 0.0 }
            }
            (None, None, (Some(length_m), Some(radius_m), Some(turn))) => {
                let left_perm = 1.0 / radius_m.value();
                let curvature_perm = if turn == Turn::Left { left_perm } else { -left_perm };
                road::Piece::Arc { length_m, curvature_perm }
            }
            _ => return None,
        })
    }
}

/// The pieces with the curvatures that spirals take from their neighbours.
pub(super) fn geometry(pieces: &[PlanPiece]) -> Result<Vec<road::Piece>, Problem> {
    let refuse = |index: usize, message: &str, expected: &str| {
        Problem::new(format!("road.plan.pieces.{index}"), message, expected)
    };
    let alone = |(index, piece): (usize, &PlanPiece)| {
        piece.alone().ok_or_else(|| refuse(index, "these keys are not a piece of a road", FORMS))
    };
    let mut road = pieces.iter().enumerate().map(alone).collect::<Result<Vec<_>, _>>()?;
    let curvature_perm = |piece: &road::Piece| match *piece {
        road::Piece::Line { .. } => Some(0.0),
        road::Piece::Arc { curvature_perm, .. } => Some(curvature_perm),
        _ => None,
    };
    let curvatures: Vec<Option<f64>> = road.iter().map(curvature_perm).collect();
    let beside = |index: Option<usize>| index.and_then(|index| *curvatures.get(index)?);
    for (index, piece) in road.iter_mut().enumerate() {
        if let road::Piece::Spiral { start_perm, end_perm, .. } = piece {
            let (before, after) = (beside(index.checked_sub(1)), beside(Some(index + 1)));
            (*start_perm, *end_perm) = before.zip(after).ok_or_else(|| {
                let expected = "a line or an arc before a spiral and behind it";
                refuse(index, "this spiral lacks a curvature to join", expected)
            })?;
        }
    }
    Ok(road)
}
