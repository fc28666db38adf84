//! Chains of pieces that make no axis.

use crate::{CROSSING_WITHIN_M, MAX_GAP_M, MAX_KINK_RAD, MAX_LENGTH_M, MIN_RADIUS_M};

/// A chain of pieces that makes no axis. Pieces are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AxisError {
    /// There is no piece, or a line begins at its end.
    #[error("there is no road ahead")]
    Empty,
    /// A number is NaN or infinite.
    #[error("a number of the piece is not finite")]
    NotFinite {
        /// The piece.
        piece: usize,
    },
    /// A length that is zero or negative, or too long in sum.
    #[error("a length of {length_m} m")]
    Length {
        /// The piece.
        piece: usize,
        /// Its length, or the length up to its end if that is too long, m.
        length_m: f64,
    },
    /// A curve that is too narrow.
    #[error("a radius of {radius_m:.1} m")]
    Radius {
        /// The piece.
        piece: usize,
        /// Its smallest radius, m.
        radius_m: f64,
    },
    /// A cubic that stands still or turns back: its direction is not defined.
    #[error("a cubic that stands still at a parameter")]
    Cusp {
        /// The piece.
        piece: usize,
    },
    /// A cubic that is declared longer or shorter than it is.
    #[error("a length of {length_m} m for a cubic of {true_m:.3} m")]
    Declared {
        /// The piece.
        piece: usize,
        /// Its declared length, m.
        length_m: f64,
        /// Its length along the curve, m.
        true_m: f64,
    },
    /// Two branches of the axis cross.
    #[error("the road crosses itself at {first_m:.0} m and {second_m:.0} m")]
    Crossing {
        /// The piece of the second branch.
        piece: usize,
        /// Place of the first branch, m.
        first_m: f64,
        /// Place of the second branch, m.
        second_m: f64,
    },
    /// A piece does not begin where the one before ends.
    #[error("a gap of {gap_m:.3} m to the end of the piece before")]
    Gap {
        /// The piece.
        piece: usize,
        /// The gap, m.
        gap_m: f64,
    },
    /// A piece does not begin in the direction in which the one before ends.
    #[error("a kink of {kink_rad:.4} rad to the end of the piece before")]
    Kink {
        /// The piece.
        piece: usize,
        /// The kink, rad.
        kink_rad: f64,
    },
    /// A spiral that has no neighbour to take a curvature from.
    #[error("a spiral without a line or an arc on both sides")]
    Spiral {
        /// The piece.
        piece: usize,
    },
}

impl AxisError {
    /// The piece that the error is about, from 0.
    #[must_use]
    pub fn piece(&self) -> usize {
        match *self {
            Self::Empty => 0,
            Self::NotFinite { piece }
            | Self::Length { piece, .. }
            | Self::Radius { piece, .. }
            | Self::Cusp { piece }
            | Self::Declared { piece, .. }
            | Self::Crossing { piece, .. }
            | Self::Gap { piece, .. }
            | Self::Kink { piece, .. }
            | Self::Spiral { piece } => piece,
        }
    }

    /// The right form.
    ///
    /// ```
    /// use road::{Axis, Piece};
    /// let error = Axis::new(&[Piece::Arc { length_m: 5.0, curvature_perm: 0.1 }]).expect_err("too narrow");
    /// assert_eq!(format!("{error}, expected {}", error.expected()), "a radius of 10.0 m, expected at least 20 m");
    /// ```
    #[must_use]
    pub fn expected(&self) -> String {
        match self {
            Self::Empty => "a place before the road's end".to_owned(),
            Self::NotFinite { .. } => "finite numbers".to_owned(),
            Self::Length { .. } => {
                format!("a length above 0 m and at most {MAX_LENGTH_M} m in all")
            }
            Self::Radius { .. } => format!("at least {MIN_RADIUS_M} m"),
            Self::Cusp { .. } => "a cubic that always goes on".to_owned(),
            Self::Declared { .. } => "the length along the curve, within 10 %".to_owned(),
            Self::Crossing { .. } => {
                format!(
                    "no crossing of branches less than {CROSSING_WITHIN_M} m apart along the road"
                )
            }
            Self::Gap { .. } => format!("at most {MAX_GAP_M} m"),
            Self::Kink { .. } => format!("at most {MAX_KINK_RAD} rad"),
            Self::Spiral { .. } => "a spiral between lines and arcs".to_owned(),
        }
    }
}
