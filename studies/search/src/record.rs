//! The record of a run, and the value that a search makes small: the least margin of the requirements, in tolerances.
//!
//! ```text
//! value = min over requirements of margin / tolerance       where the reference keeps more than 0.5 m
//!         (0.5 m − the reference's clearance) / 0.5 m       elsewhere, above 0 and without a run
//! ```
//!
//! Tolerances are those of the requirement's unit ([`temporal_logic::Unit::tolerance`]).

use report::summary::Summary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use supervise::RequirementVerdict;
use supervise::report::Outcome;
use temporal_logic::Unit;

use crate::method::Proposal;
use crate::problem::Value;
use crate::reference::MOST;

/// A run that was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    #[serde(flatten)]
    pub driven: Proposal,
    /// Values of the variables there.
    pub values: Vec<Value>,
    pub seed: u64,
    pub outcome: Outcome,
    /// The requirement that decides it.
    pub judged: Judged,
}

impl Record {
    /// The value that the search makes small. Below 0 the run is a failure, as the reference avoids each point that is
    /// driven.
    pub fn value(&self) -> f64 {
        self.judged.robustness
    }

    pub fn is_failure(&self) -> bool {
        self.value() < 0.0
    }

    /// The result as the choice of later runs needs it. The last digit of a number may differ where it comes from a
    /// journal: values count in millionths.
    pub(crate) fn told(&self) -> (Proposal, f64) {
        let rough = |number: &f64| (number * 1e6).round() / 1e6;
        let place = |point: &Vec<f64>| point.iter().map(rough).collect();
        let refused = self.driven.refused.iter().map(place).collect();
        let driven = Proposal { point: place(&self.driven.point), refused, ..self.driven };
        (driven, rough(&self.value()))
    }
}

/// Units whose tolerance is not 1.
const UNITS: [Unit; 5] = [
    Unit::METRE,
    Unit::SECOND,
    Unit::METRE_PER_SECOND,
    Unit::METRE_PER_SECOND_SQUARED,
    Unit::METRE_PER_SECOND_CUBED,
];

/// The requirement that decides a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// Its margin in tolerances, between -200 and 200.
    pub robustness: f64,
    pub requirement: String,
    /// Its margin in its unit; none where nothing of the drive decides it.
    pub margin: Option<f64>,
    pub unit: String,
}

/// The requirement of a run with the least margin in tolerances; a run without requirements holds.
pub fn judge(summary: &Summary) -> Judged {
    let worst = summary.requirements.iter().map(|verdict| (in_tolerances(verdict), verdict));
    let worst = worst.min_by(|a, b| a.0.total_cmp(&b.0));
    let nothing = Judged { robustness: MOST, ..Judged::default() };
    worst.map_or(nothing, |(robustness, verdict)| Judged {
        robustness,
        requirement: verdict.requirement.clone(),
        margin: verdict.margin,
        unit: verdict.unit.clone(),
    })
}

/// A margin in tolerances of its unit.
pub fn in_tolerances(verdict: &RequirementVerdict) -> f64 {
    let Some(margin) = verdict.margin else { return if verdict.met { MOST } else { -MOST } };
    let unit = UNITS.into_iter().find(|known| known.to_string() == verdict.unit);
    let value = (margin / unit.map_or(1.0, Unit::tolerance)).clamp(-MOST, MOST);
    // Rounding does not turn a verdict.
    if verdict.met { value.max(0.0) } else { value.min(-f64::MIN_POSITIVE) }
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
