//! The value that a search makes small: the least margin of the requirements, in tolerances.
//!
//! ```text
//! value = min over requirements of margin / tolerance       where the reference keeps more than 0.5 m
//!         (0.5 m − the reference's clearance) / 0.5 m       elsewhere, above 0 and without a run
//! ```
//!
//! A negative value is a failure: a requirement is broken in a scene that the reference driver avoids. Tolerances are
//! those of the requirement's unit ([`temporal_logic::Unit::tolerance`]).

use group::RequirementVerdict;
use report::summary::Summary;
use serde::{Deserialize, Serialize};
use temporal_logic::Unit;

/// The requirement of a search that names none.
pub const DEFAULT_REQUIREMENT: &str = "no-collision";

/// Largest magnitude of a value, tolerances. Margins on an empty road are infinite.
pub(crate) const MOST: f64 = 200.0;

/// Units whose tolerance is not 1.
const UNITS: [Unit; 5] = [
    Unit::METRE,
    Unit::SECOND,
    Unit::METRE_PER_SECOND,
    Unit::METRE_PER_SECOND_SQUARED,
    Unit::METRE_PER_SECOND_CUBED,
];

/// The requirement that decides a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Its margin in tolerances, between -200 and 200.
    pub value: f64,
    pub requirement: String,
    /// Its margin in its unit; none where nothing of the drive decides it.
    pub margin: Option<f64>,
    pub unit: String,
}

/// The requirement of a run with the least margin in tolerances; a run without requirements holds.
#[must_use]
pub fn judge(summary: &Summary) -> Judged {
    let worst = summary.requirements.iter().map(|verdict| (in_tolerances(verdict), verdict));
    let worst = worst.min_by(|a, b| a.0.total_cmp(&b.0));
    let nothing =
        Judged { value: MOST, requirement: String::new(), margin: None, unit: String::new() };
    worst.map_or(nothing, |(value, verdict)| Judged {
        value,
        requirement: verdict.requirement.clone(),
        margin: verdict.margin,
        unit: verdict.unit.clone(),
    })
}

/// A margin in tolerances of its unit.
#[must_use]
pub fn in_tolerances(verdict: &RequirementVerdict) -> f64 {
    let Some(margin) = verdict.margin else { return if verdict.met { MOST } else { -MOST } };
    let value = (margin / tolerance(&verdict.unit)).clamp(-MOST, MOST);
    // Rounding does not turn a verdict.
    if verdict.met { value.max(0.0) } else { value.min(-f64::MIN_POSITIVE) }
}

/// Tolerance of a unit by its text.
#[must_use]
pub fn tolerance(unit: &str) -> f64 {
    UNITS.into_iter().find(|known| known.to_string() == unit).map_or(1.0, Unit::tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(margin: Option<f64>, unit: &str, met: bool) -> RequirementVerdict {
        let (requirement, formula, unit) = ("a".to_owned(), "a".to_owned(), unit.to_owned());
        RequirementVerdict { requirement, formula, margin, unit, at_s: 0.0, met }
    }

    #[test]
    fn margins_count_tolerances_of_their_unit() {
        for (margin, unit, met, expected) in [
            (Some(1.0), "m", true, 2.0),
            (Some(-0.3), "s", false, -3.0),
            (Some(-2.0), "tolerances", false, -2.0),
            (None, "m", true, MOST),
            (None, "m", false, -MOST),
            (Some(1e9), "m", true, MOST),
        ] {
            let found = in_tolerances(&verdict(margin, unit, met));
            assert!((found - expected).abs() < 1e-12, "{margin:?} {unit}: {found}");
        }
        assert!(in_tolerances(&verdict(Some(-0.0), "m", false)) < 0.0);
    }
}
