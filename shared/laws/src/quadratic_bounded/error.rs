//! Why a file is not a design.

use scenario::Problem;
use thiserror::Error;

/// Largest accepted file, bytes; a design needs about 8000.
pub(super) const LARGEST: usize = 64 * 1024;
/// Claims of the file.
pub(super) const FORMAT: &str = "timegap quadratic-bounded design 1";

/// The conditions of a certificate, in the words of its errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Condition {
    #[error("P is symmetric")]
    Symmetric,
    #[error("multipliers are positive and sum to at most alpha < 1")]
    Multipliers,
    #[error("P is positive definite")]
    PositiveDefinite,
    #[error("the ellipsoid is invariant (quadratic boundedness)")]
    Invariance,
    #[error("gap error rate within its bound")]
    GapErrorRate,
    #[error("increment within its bound")]
    Increment,
    #[error("gap error within its bound")]
    GapError,
    #[error("speed error within its bound")]
    SpeedError,
    #[error("acceleration within its bound")]
    Acceleration,
    #[error("request within its bound")]
    Request,
    #[error("start states inside the ellipsoid")]
    StartSet,
}

/// A condition that does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "condition not met: {condition}{} (found {value:.6e}, limit {bound:.6e})",
    rule.map_or_else(String::new, |rule| format!(", rule {rule}"))
)]
pub struct Failure {
    pub condition: Condition,
    /// Number of the rule, 1 or 2, where the condition is one of a rule.
    pub rule: Option<usize>,
    /// Found value: that of the index, or the least scaled pivot.
    pub value: f64,
    pub bound: f64,
}

/// Reason why a file is not a usable design.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DesignError {
    #[error("the design file cannot be read: {0}")]
    Read(String),
    #[error("the design file has {bytes} bytes, more than {LARGEST}")]
    TooLarge { bytes: usize },
    /// Not JSON of the right shape; the message has line and column.
    #[error("not a design file: {0}")]
    Syntax(String),
    /// Another format or version, as found.
    #[error("format {0:?}: expected {FORMAT:?}")]
    Format(String),
    #[error("design parameter {}, expected {}", .0.message, .0.expected)]
    Parameter(Problem),
    #[error("the certificate fails: {0}")]
    Condition(#[from] Failure),
}
