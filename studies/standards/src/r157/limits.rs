//! Limits of the study. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-25 | collisions in the cut-ins that both models master, low and high together | 0.5 % | chosen; UN R157, 5.2.5.2, allows none |
//! | 2026-11-21 | collisions in each part of the cut-ins | a third of `regulation`'s | chosen |
//! | 2026-11-21 | collisions while following | 0 | UN R157, 5.2.5.2 |
//! | 2026-11-25 | collisions in the cut-outs that `careful-driver` masters from the law's gap | 0.5 % | chosen; UN R157, 5.2.5.2, allows none |
//!
//! A law with the emergency brake has to hold its limits. A law alone is measured against the same limits, and the
//! result names it. It does not decide the exit status.

use super::matrix::Matrix;

/// Share of the cases that a model masters in which a law may collide.
const AVOIDABLE_SHARE: f64 = 0.005;
/// Collisions of a law, times this, are at most those of `regulation`.
pub const COLLISIONS_OF_REGULATION: u32 = 3;

/// A limit over some cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Collisions in at most [`AVOIDABLE_SHARE`] of the cases that both models master.
    MasteredByBoth,
    /// Collisions in no more than a third of the cases in which `regulation` collides.
    ThirdOfRegulation,
    /// No collision.
    NoCollision,
    /// Collisions in at most [`AVOIDABLE_SHARE`] of the cases that `careful-driver` masters from the law's gap.
    MasteredFromItsGap,
}

impl Limit {
    /// Limits over all the cases of a matrix.
    pub fn of_whole(matrix: Matrix) -> &'static [Self] {
        match matrix {
            Matrix::CutIn => &[Self::MasteredByBoth],
            Matrix::Following => &[Self::NoCollision],
            Matrix::CutOut => &[Self::MasteredFromItsGap],
        }
    }

    /// Limits over each part of a matrix with parts.
    pub fn of_parts(matrix: Matrix) -> &'static [Self] {
        match matrix {
            Matrix::CutIn => &[Self::ThirdOfRegulation],
            Matrix::Following | Matrix::CutOut => &[],
        }
    }

    /// The criterion in words.
    pub fn criterion(self) -> String {
        let percent = 100.0 * AVOIDABLE_SHARE;
        match self {
            Self::MasteredByBoth => {
                format!("collisions in at most {percent} % of the cases that both models master")
            }
            Self::ThirdOfRegulation => {
                "collisions in at most a third of the cases in which regulation collides".to_owned()
            }
            Self::NoCollision => "no collision".to_owned(),
            Self::MasteredFromItsGap => format!(
                "collisions in at most {percent} % of the cases that careful-driver masters from the law's gap"
            ),
        }
    }
}

/// True if a law collides in few enough of the cases that a model masters.
pub fn are_few(avoidable: u32, mastered: u32) -> bool {
    f64::from(avoidable) <= AVOIDABLE_SHARE * f64::from(mastered)
}
