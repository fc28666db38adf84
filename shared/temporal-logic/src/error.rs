//! Errors of a formula, with their place in its text.

use crate::Unit;
use std::ops::Range;
use thiserror::Error;

/// A formula that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("column {column}: {problem}\n  | {text}\n  | {marks}", marks = self.marks())]
pub struct FormulaError {
    /// First column concerned, counted in characters from 1.
    pub column: usize,
    /// Columns concerned.
    pub width: usize,
    pub problem: Problem,
    pub text: String,
}

/// The fault of a formula.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Problem {
    #[error("{found}, expected {expected}")]
    Unexpected {
        /// The word that stands there.
        found: String,
        /// The words that may stand there.
        expected: &'static str,
    },
    #[error("unknown signal \"{name}\", expected one of {}{}", known.join(", "), hint(nearest))]
    UnknownSignal {
        name: String,
        /// The signals that exist.
        known: Vec<&'static str>,
        /// The most similar one.
        nearest: Option<&'static str>,
    },
    #[error("{left} and {right} cannot be added or compared")]
    Units { left: Unit, right: Unit },
    #[error("a number, expected a condition such as gap_m > 2")]
    NumberForCondition,
    #[error("a condition, expected a number or a signal")]
    ConditionForNumber,
    /// A window that is empty or begins in the past.
    #[error("a window from {first_s} s to {last_s} s, expected 0 <= first <= last")]
    Window { first_s: f64, last_s: f64 },
    /// A window that no run is long enough for.
    #[error("the window ends after the run, which lasts {duration_s} s")]
    LongWindow {
        /// Length of the run.
        duration_s: f64,
    },
    /// More nesting than a reader could follow.
    #[error("nested more than {most} deep")]
    Depth { most: usize },
}

fn hint(nearest: &Option<&'static str>) -> String {
    nearest.map_or_else(String::new, |name| format!(", did you mean {name}?"))
}

impl FormulaError {
    pub(crate) fn at(text: &str, place: Range<usize>, problem: Problem) -> Self {
        let characters =
            |range: Range<usize>| text.get(range).map_or(0, |part| part.chars().count());
        let column = characters(0..place.start) + 1;
        Self { column, width: characters(place).max(1), problem, text: text.to_owned() }
    }

    fn marks(&self) -> String {
        " ".repeat(self.column - 1) + &"^".repeat(self.width)
    }
}
