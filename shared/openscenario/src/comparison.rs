//! Rules that compare two values.

use crate::expression::Value;

/// A rule that compares two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Equal.
    EqualTo,
    /// Not equal.
    NotEqualTo,
    /// Greater.
    GreaterThan,
    /// Less.
    LessThan,
    /// Greater or equal.
    GreaterOrEqual,
    /// Less or equal.
    LessOrEqual,
}

impl Rule {
    /// True if it holds between numbers.
    ///
    /// ```
    /// use openscenario::Rule;
    ///
    /// assert!(Rule::LessThan.holds(1.0, 2.0));
    /// ```
    #[must_use]
    pub fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::EqualTo => left == right,
            Self::NotEqualTo => left != right,
            Self::GreaterThan => left > right,
            Self::LessThan => left < right,
            Self::GreaterOrEqual => left >= right,
            Self::LessOrEqual => left <= right,
        }
    }

    /// True if it holds between values: as numbers where both are numbers, as text otherwise.
    #[must_use]
    pub fn compares(self, left: &Value, right: &Value) -> bool {
        match (left.number(), right.number()) {
            (Some(left), Some(right)) => self.holds(left, right),
            _ => match self {
                Self::EqualTo => left.text() == right.text(),
                Self::NotEqualTo => left.text() != right.text(),
                _ => false,
            },
        }
    }
}
