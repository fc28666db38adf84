//! Chains of pieces that make no axis.

use crate::{CROSSING_WITHIN_M, MAX_GAP_M, MAX_KINK_RAD, MAX_LENGTH_M, MIN_RADIUS_M};

/// A chain of pieces that makes no axis.
///
/// ```
/// use road::{Axis, Piece};
/// let error = Axis::new(&[Piece::Arc { length_m: 5.0, curvature_perm: 0.1 }]).expect_err("too narrow");
/// assert_eq!(format!("{error}, expected {}", error.expected()), "a radius of 10.0 m, expected at least 20 m");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{fault}")]
pub struct AxisError {
    /// The piece that is wrong, counted from 0.
    pub piece: usize,
    pub fault: AxisFault,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AxisFault {
    /// There is no piece, or a line begins at its end.
    #[error("there is no road ahead")]
    Empty,
    #[error("a number of the piece is not finite")]
    NotFinite,
    /// A length in m that is zero or negative, or too long in sum.
    #[error("a length of {0} m")]
    Length(f64),
    /// A curve that is too narrow: its smallest radius, m.
    #[error("a radius of {0:.1} m")]
    Radius(f64),
    /// A cubic that stands still or turns back: its direction is not defined.
    #[error("a cubic that stands still at a parameter")]
    Cusp,
    /// A cubic that is declared longer or shorter than it is along the curve.
    #[error("a length of {length_m} m for a cubic of {true_m:.3} m")]
    Declared { length_m: f64, true_m: f64 },
    #[error("the road crosses itself at {first_m:.0} m and {second_m:.0} m")]
    Crossing { first_m: f64, second_m: f64 },
    #[error("a gap of {0:.3} m to the end of the piece before")]
    Gap(f64),
    /// The piece does not begin in the direction in which the one before ends, rad.
    #[error("a kink of {0:.4} rad to the end of the piece before")]
    Kink(f64),
}

impl AxisFault {
    pub(crate) fn of(self, piece: usize) -> AxisError {
        AxisError { piece, fault: self }
    }
}

impl AxisError {
    /// The right form.
    pub fn expected(&self) -> String {
        match self.fault {
            AxisFault::Empty => "a place before the road's end".to_owned(),
            AxisFault::NotFinite => "finite numbers".to_owned(),
            AxisFault::Length(_) => {
                format!("a length above 0 m and at most {MAX_LENGTH_M} m in all")
            }
            AxisFault::Radius(_) => format!("at least {MIN_RADIUS_M} m"),
            AxisFault::Cusp => "a cubic that always goes on".to_owned(),
            AxisFault::Declared { .. } => "the length along the curve, within 10 %".to_owned(),
            AxisFault::Crossing { .. } => {
                format!(
                    "no crossing of branches less than {CROSSING_WITHIN_M} m apart along the road"
                )
            }
            AxisFault::Gap(_) => format!("at most {MAX_GAP_M} m"),
            AxisFault::Kink(_) => format!("at most {MAX_KINK_RAD} rad"),
        }
    }
}
