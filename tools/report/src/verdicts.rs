//! Columns of requirements' verdicts, for the results of studies.

use super::results::{Column, flag, number, word};
use crate::print;
use group::RequirementVerdict;

/// Columns of a run's verdicts on its requirements.
pub const COLUMNS: &[Column<RequirementVerdict>] = &[
    word("requirement", "requirement", "The requirement as it was given"),
    word("formula", "", "Its formula, or its rule in words"),
    number("margin", "margin", "", 2, "Distance to violation; null where nothing decides it"),
    word("unit", "unit", "Unit of the margin"),
    number("at_s", "at", "s", 2, "Run time of the instant that decides it"),
    flag("met", "", ("met", "broken"), "The requirement holds"),
];

/// The verdicts in words, for a cell of a table; `None` without a requirement.
pub fn words(verdicts: &[RequirementVerdict]) -> Option<String> {
    let each = verdicts
        .iter()
        .map(|verdict| format!("{}: {}", verdict.requirement, print::requirement(verdict)));
    (!verdicts.is_empty()).then(|| each.collect::<Vec<_>>().join("; "))
}
