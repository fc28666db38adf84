//! The pieces of a plan.

use scenario_derive::tables;
use serde::{Deserialize, Serialize};

use crate::Problem;
use crate::quantity::{CurveRadius, PieceLength};
use crate::schema::{Schema, Shape};

/// A piece of the road.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PieceKeys", into = "PieceKeys")]
pub enum PlanPiece {
    /// A straight line.
    Line {
        /// Length, m.
        length_m: PieceLength,
    },
    /// A circular arc.
    Arc {
        /// Length, m.
        length_m: PieceLength,
        /// Radius, m.
        radius_m: CurveRadius,
        /// Side to which it turns.
        turn: Turn,
    },
    /// A clothoid that joins the curvatures of its neighbours.
    Spiral {
        /// Length, m.
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

    /// The keys of a piece: one length, and with `arc_m` the other two.
    #[derive(Copy)]
    pub struct PieceKeys {
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
}

/// Keys that are not a piece of a road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("these keys are not a piece of a road, expected {FORMS}")]
pub struct NoPiece;

const FORMS: &str = "{ line_m }, { spiral_m } or { arc_m, radius_m, turn }";

impl Schema for PlanPiece {
    fn shape() -> Shape {
        PieceKeys::shape()
    }

    fn expected() -> Option<String> {
        Some(FORMS.to_owned())
    }
}

impl TryFrom<PieceKeys> for PlanPiece {
    type Error = NoPiece;

    fn try_from(keys: PieceKeys) -> Result<Self, NoPiece> {
        match keys {
            PieceKeys {
                line_m: Some(length_m),
                arc_m: None,
                spiral_m: None,
                radius_m: None,
                turn: None,
            } => Ok(Self::Line { length_m }),
            PieceKeys {
                line_m: None,
                arc_m: None,
                spiral_m: Some(length_m),
                radius_m: None,
                turn: None,
            } => Ok(Self::Spiral { length_m }),
            PieceKeys {
                line_m: None,
                arc_m: Some(length_m),
                spiral_m: None,
                radius_m: Some(radius_m),
                turn: Some(turn),
            } => Ok(Self::Arc { length_m, radius_m, turn }),
            _ => Err(NoPiece),
        }
    }
}

impl From<PlanPiece> for PieceKeys {
    fn from(piece: PlanPiece) -> Self {
        let none = Self::default();
        match piece {
            PlanPiece::Line { length_m } => Self { line_m: Some(length_m), ..none },
            PlanPiece::Spiral { length_m } => Self { spiral_m: Some(length_m), ..none },
            PlanPiece::Arc { length_m, radius_m, turn } => {
                Self { arc_m: Some(length_m), radius_m: Some(radius_m), turn: Some(turn), ..none }
            }
        }
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
