//! The pieces of a plan.

use scenario_derive::tables;
use serde::{Deserialize, Serialize};

use crate::Problem;
use crate::quantity::{CurveRadius, PieceLength};
use crate::schema::{Key, Schema, Shape};

/// A piece of the road.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
#[serde(
    expecting = "these keys are not a piece of a road, expected { line_m }, { spiral_m } or { arc_m, radius_m, turn }"
)]
pub enum PlanPiece {
    /// A straight line.
    Line {
        /// Length, m.
        #[serde(rename = "line_m")]
        length_m: PieceLength,
    },
    /// A circular arc.
    Arc {
        /// Length, m.
        #[serde(rename = "arc_m")]
        length_m: PieceLength,
        /// Radius, m.
        radius_m: CurveRadius,
        /// Side to which it turns.
        turn: Turn,
    },
    /// A clothoid that joins the curvatures of its neighbours.
    Spiral {
        /// Length, m.
        #[serde(rename = "spiral_m")]
        length_m: PieceLength,
    },
}

tables! {
    /// Side to which an arc turns.
    pub enum Turn {
        /// To the left.
        Left,
        /// To the right.
        Right,
    }
}

impl Schema for PlanPiece {
    /// The keys of all pieces.
    fn shape() -> Shape {
        let length = |name, meaning| Key::of::<PieceLength>(name, meaning, Some(None));
        Shape::Table(vec![
            length("line_m", "Length of a straight line, m."),
            length("arc_m", "Length of a circular arc, m."),
            length("spiral_m", "Length of a clothoid, m."),
            Key::of::<CurveRadius>("radius_m", "Radius of an arc, m.", Some(None)),
            Key::of::<Turn>("turn", "Side to which an arc turns.", Some(None)),
        ])
    }
}

impl PlanPiece {
    /// Curvature, 1/m, left positive; `None` for a spiral, which has that of its neighbours.
    fn curvature_perm(&self) -> Option<f64> {
        match self {
            Self::Line { .. } => Some(0.0),
            Self::Arc { radius_m, turn: Turn::Left, .. } => Some(1.0 / radius_m.value()),
            Self::Arc { radius_m, turn: Turn::Right, .. } => Some(-1.0 / radius_m.value()),
            Self::Spiral { .. } => None,
        }
    }
}

/// The pieces with the curvatures that spirals take from their neighbours.
pub(super) fn geometry(pieces: &[PlanPiece]) -> Result<Vec<road::Piece>, Problem> {
    let beside = |index: Option<usize>| index.and_then(|index| pieces.get(index)?.curvature_perm());
    let piece = |(index, piece): (usize, &PlanPiece)| match piece {
        PlanPiece::Line { length_m } => Ok(road::Piece::Line { length_m: length_m.value() }),
        PlanPiece::Arc { length_m, .. } => Ok(road::Piece::Arc {
            length_m: length_m.value(),
            curvature_perm: piece.curvature_perm().unwrap_or_default(),
        }),
        PlanPiece::Spiral { length_m } => {
            let (before, after) = (beside(index.checked_sub(1)), beside(Some(index + 1)));
            let (Some(start_perm), Some(end_perm)) = (before, after) else {
                return Err(Problem::new(
                    format!("road.plan.pieces.{index}"),
                    "this spiral lacks a curvature to join",
                    "a line or an arc before a spiral and behind it",
                ));
            };
            Ok(road::Piece::Spiral { length_m: length_m.value(), start_perm, end_perm })
        }
    };
    pieces.iter().enumerate().map(piece).collect()
}
