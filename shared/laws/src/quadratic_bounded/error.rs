//! Why a file is not a design.

use law::settings::SettingError;
use thiserror::Error;

/// Largest accepted file, bytes; a design needs about 8000.
pub(super) const LARGEST: usize = 64 * 1024;
/// Claims of the file.
pub(super) const FORMAT: &str = "timegap quadratic-bounded design 1";

/// The conditions of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// P is symmetric.
    Symmetric,
    /// 0 < alpha < 1, a_j > 0, sum a_j <= alpha.
    Multipliers,
    /// P > 0.
    PositiveDefinite,
    /// The ellipsoid cannot be left.
    Invariance,
    /// |Dd'| within its bound.
    GapErrorRate,
    /// |Du| within its bound.
    Increment,
    /// |Dd| within its bound.
    GapError,
    /// |Dv| within its bound.
    SpeedError,
    /// |a| within its bound.
    Acceleration,
    /// |u| within its bound.
    Request,
    /// The start states are in the ellipsoid.
    StartSet,
}

impl Condition {
    fn text(self) -> &'static str {
        match self {
            Self::Symmetric => "P is symmetric",
            Self::Multipliers => "multipliers are positive and sum to at most alpha < 1",
            Self::PositiveDefinite => "P is positive definite",
            Self::Invariance => "the ellipsoid is invariant (quadratic boundedness)",
            Self::GapErrorRate => "gap error rate within its bound",
            Self::Increment => "increment within its bound",
            Self::GapError => "gap error within its bound",
            Self::SpeedError => "speed error within its bound",
            Self::Acceleration => "acceleration within its bound",
            Self::Request => "request within its bound",
            Self::StartSet => "start states inside the ellipsoid",
        }
    }
}

/// A condition that does not hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// Condition.
    pub condition: Condition,
    /// Number of the rule, 1 or 2, where the condition is one of a rule.
    pub rule: Option<usize>,
    /// Found value: that of the index, or the least scaled pivot.
    pub value: f64,
    /// Limit for it.
    pub bound: f64,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "condition not met: {}", self.condition.text())?;
        if let Some(rule) = self.rule {
            write!(f, ", rule {rule}")?;
        }
        write!(f, " (found {:.6e}, limit {:.6e})", self.value, self.bound)
    }
}

impl std::error::Error for Failure {}

/// Reason why a file is not a usable design.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DesignError {
    /// The file cannot be read.
    #[error("the design file cannot be read: {0}")]
    Read(String),
    /// Longer than any design.
    #[error("the design file has {bytes} bytes, more than {LARGEST}")]
    TooLarge {
        /// Length of the text.
        bytes: usize,
    },
    /// Not JSON of the right shape; the message has line and column.
    #[error("not a design file: {0}")]
    Syntax(String),
    /// Another format or version, as found.
    #[error("format {0:?}: expected {FORMAT:?}")]
    Format(String),
    /// A parameter outside its range.
    #[error("design parameter {0}")]
    Parameter(#[from] SettingError),
    /// A number too large to compute with.
    #[error("number {0:e} in the design: expected at most 1e9")]
    Number(f64),
    /// The certificate fails.
    #[error("the certificate fails: {0}")]
    Condition(#[from] Failure),
    /// The numbers are not those that were certified, though they pass.
    #[error("the digest does not match: the numbers were changed after the design was made")]
    Digest,
}
