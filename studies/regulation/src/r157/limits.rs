//! The limits that a law with the emergency brake has to hold; one alone has none.

use super::matrix::Matrix;

/// Share of the cases that a model masters in which a law with the emergency brake may collide.
const AVOIDABLE_SHARE: f64 = 0.005;

/// A limit over some cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Of the cases that both models master the law collides in at most [`AVOIDABLE_SHARE`].
    MasteredByBoth,
    /// It collides in no more than a third of the cases in which `regulation` does.
    ThirdOfRegulation,
    /// It never collides.
    NoCollision,
    /// Of the cases that `careful-driver` masters from the gap that the law keeps it collides in at most
    /// [`AVOIDABLE_SHARE`].
    MasteredFromItsGap,
}

impl Limit {
    /// Those over all the cases of a matrix.
    pub fn of_whole(matrix: Matrix) -> &'static [Self] {
        match matrix {
            Matrix::CutIn => &[Self::MasteredByBoth],
            Matrix::Following => &[Self::NoCollision],
            Matrix::CutOut => &[Self::MasteredFromItsGap],
        }
    }

    /// Those over each part of a matrix that has parts.
    pub fn of_parts(matrix: Matrix) -> &'static [Self] {
        match matrix {
            Matrix::CutIn => &[Self::ThirdOfRegulation],
            Matrix::Following | Matrix::CutOut => &[],
        }
    }
}

/// Whether a law collides in few enough of the cases that a model masters.
pub fn are_few(avoidable: u32, mastered: u32) -> bool {
    f64::from(avoidable) <= AVOIDABLE_SHARE * f64::from(mastered)
}
