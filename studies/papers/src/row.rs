//! One figure to be reproduced, beside ours.
//!
//! The expected value has one of three sources, and every row names it. The *paper* prints it. The
//! *reconstruction* gives values that the paper does not print. A *requirement* holds for any working
//! controller. A fourth kind is no result. An *input* is a value that the scenario or the code puts in, such as a
//! constant or a clamp. It is shown beside the printed one, and it is outside every count.
//!
//! A row belongs to a set: one variant of law, scene and weights. A printed figure keeps its id in
//! all sets, so that it counts once ([`super::tally`]). A row outside its tolerance fails, also in
//! a set of an uncertified law. The reproduction's verdict is then false, and the exit status 1.
//! `docs/papers.md` names each such row with its reason.

use report::chart::number;
use report::table::NONE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Source of the expected value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Printed by the paper, as a number or in a plot.
    Paper,
    /// From a reference implementation of what the paper does not print.
    Reconstruction,
    /// Demanded of the controller.
    Requirement,
    /// Put in by the scenario or the code: shown, outside every count.
    Input,
}

/// Comparison of ours with the expected value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// Ours is within the tolerance on both sides.
    Near,
    /// Our figure is at most the expected value plus the tolerance.
    AtMost,
    /// Our figure is at least the expected value minus the tolerance.
    AtLeast,
    /// Not compared.
    Shown,
}

/// A value to be reproduced, and its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    kind: Kind,
    value: f64,
}

pub const fn paper(value: f64) -> Expected {
    Expected { kind: Kind::Paper, value }
}

pub const fn reconstruction(value: f64) -> Expected {
    Expected { kind: Kind::Reconstruction, value }
}

pub const fn requirement(value: f64) -> Expected {
    Expected { kind: Kind::Requirement, value }
}

/// Largest accepted difference, in the figure's unit, and why it is that large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    value: f64,
    reason: &'static str,
}

pub const fn within(value: f64, reason: &'static str) -> Tolerance {
    Tolerance { value, reason }
}

/// No difference is accepted.
pub const EXACT: Tolerance = within(0.0, "exact");

/// An expected figure and the one of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Scenario and figure, joined by dots; the same in all sets.
    pub id: String,
    /// Variant of law, scene and weights that the row belongs to; empty where there is only one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub set: String,
    /// Set of weights, where there are several: the name that it has had in results from the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<Cow<'static, str>>,
    /// Sentence, figure or equation of the paper behind the expected value, shortened.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Cow<'static, str>>,
    /// Inferred value that the row depends on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inferred: Option<Cow<'static, str>>,
    /// Source of the expected value.
    pub kind: Kind,
    /// Unit of the numbers.
    pub unit: Cow<'static, str>,
    /// The paper's value; null where the paper prints no number.
    pub paper: Option<f64>,
    /// Expected value: the paper's value in rows of its kind; null where nothing is compared.
    pub expected: Option<f64>,
    /// Ours; null where the run never got there.
    pub ours: Option<f64>,
    /// Comparison.
    pub check: Check,
    /// Largest accepted difference; null where nothing is compared.
    pub tolerance: Option<f64>,
    /// Reason why the tolerance is that large.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_reason: Option<Cow<'static, str>>,
    /// True if ours is accepted.
    pub ok: bool,
    /// Origin of ours, or a remark beside the number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<Cow<'static, str>>,
}

/// Result of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Within,
    Outside,
    /// Shown, not compared.
    Shown,
}

type Unit = &'static str;

impl Row {
    /// A figure that must be within the tolerance on both sides.
    pub fn near(id: &str, unit: Unit, to: Expected, ours: Option<f64>, by: Tolerance) -> Self {
        Self::new(id, unit, to.kind, ours).compared(to, by, Check::Near)
    }

    /// A figure that must not exceed the expected one by more than the tolerance.
    pub fn at_most(id: &str, unit: Unit, to: Expected, ours: Option<f64>, by: Tolerance) -> Self {
        Self::new(id, unit, to.kind, ours).compared(to, by, Check::AtMost)
    }

    /// A figure that must not be below the expected one by more than the tolerance.
    pub fn at_least(id: &str, unit: Unit, to: Expected, ours: Option<f64>, by: Tolerance) -> Self {
        Self::new(id, unit, to.kind, ours).compared(to, by, Check::AtLeast)
    }

    /// A figure without a number to compare it with.
    pub fn shown(id: &str, unit: Unit, kind: Kind, ours: Option<f64>, note: &'static str) -> Self {
        Self::new(id, unit, kind, ours).with_note(note)
    }

    /// A value that the scenario or the code puts in, beside the expected one.
    pub fn input(id: &str, unit: Unit, expected: Expected, ours: Option<f64>) -> Self {
        let row = Self::new(id, unit, Kind::Input, ours);
        Self { paper: expected.of_paper(), expected: Some(expected.value), ..row }
    }

    fn new(id: &str, unit: Unit, kind: Kind, ours: Option<f64>) -> Self {
        Self {
            id: id.into(),
            set: String::new(),
            weights: None,
            source: None,
            inferred: None,
            kind,
            unit: unit.into(),
            paper: None,
            expected: None,
            ours,
            check: Check::Shown,
            tolerance: None,
            tolerance_reason: None,
            ok: true,
            note: None,
        }
    }

    fn compared(self, expected: Expected, tolerance: Tolerance, check: Check) -> Self {
        let off = |ours: f64| match check {
            Check::AtMost => ours - expected.value,
            Check::AtLeast => expected.value - ours,
            Check::Near | Check::Shown => (ours - expected.value).abs(),
        };
        Self {
            paper: expected.of_paper(),
            expected: Some(expected.value),
            check,
            tolerance: Some(tolerance.value),
            tolerance_reason: Some(tolerance.reason.into()),
            ok: self.ours.is_some_and(|ours| off(ours) <= tolerance.value + 1e-9),
            ..self
        }
    }

    /// The same row with a remark beside the number.
    pub fn with_note(self, note: &'static str) -> Self {
        Self { note: Some(note.into()), ..self }
    }

    /// The same row with the sentence, figure or equation of the paper behind it.
    pub fn with_source(self, source: &'static str) -> Self {
        Self { source: Some(source.into()), ..self }
    }

    /// The same row in a set: a variant of law, scene and weights.
    pub fn in_set(self, set: &str) -> Self {
        Self { set: set.into(), ..self }
    }

    /// The same row with the inferred value that it depends on.
    pub fn depending_on(self, inferred: impl Into<Cow<'static, str>>) -> Self {
        Self { inferred: Some(inferred.into()), ..self }
    }

    pub fn verdict(&self) -> Verdict {
        match (self.check, self.ok) {
            (Check::Shown, _) => Verdict::Shown,
            (_, true) => Verdict::Within,
            (_, false) => Verdict::Outside,
        }
    }

    /// The expected value in words, with `≤` or `≥` for a bound.
    pub fn expectation(&self) -> String {
        let value = self.expected.map_or_else(|| NONE.into(), |value| number(value, 2));
        match self.check {
            Check::AtMost => format!("≤ {value}"),
            Check::AtLeast => format!("≥ {value}"),
            Check::Near | Check::Shown => value,
        }
    }

    /// The tolerance in words; nothing where none applies.
    pub fn tolerance_in_words(&self) -> String {
        match (self.check, self.tolerance) {
            (_, None) => String::new(),
            (Check::AtMost, Some(tolerance)) => format!("+ {tolerance:.2}"),
            (Check::AtLeast, Some(tolerance)) => format!("− {tolerance:.2}"),
            (_, Some(tolerance)) => format!("± {tolerance:.2}"),
        }
    }
}

impl Expected {
    fn of_paper(self) -> Option<f64> {
        (self.kind == Kind::Paper).then_some(self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TENTH: Tolerance = within(0.1, "a reason");

    #[test]
    fn rows_are_judged_by_their_tolerance() {
        let near = |ours| Row::near("a", "s", paper(4.0), ours, TENTH).verdict();
        assert_eq!(near(Some(3.9)), Verdict::Within);
        assert_eq!(near(Some(3.89)), Verdict::Outside);
        assert_eq!(near(None), Verdict::Outside);
        let most = Row::at_most("a", "s", requirement(30.0), Some(24.0), TENTH);
        assert_eq!(most.verdict(), Verdict::Within);
        let least = |ours| Row::at_least("a", "s", paper(6.0), Some(ours), TENTH).verdict();
        assert_eq!((least(5.9), least(5.8)), (Verdict::Within, Verdict::Outside));
        let shown = Row::shown("a", "m", Kind::Paper, Some(1.0), "large");
        assert_eq!(shown.verdict(), Verdict::Shown);
        let input = Row::input("a", "m", paper(4.0), Some(1.0));
        assert_eq!(
            (input.verdict(), input.paper, input.kind),
            (Verdict::Shown, Some(4.0), Kind::Input)
        );
    }

    #[test]
    fn only_what_the_paper_prints_is_called_the_papers() {
        assert_eq!(Row::near("a", "s", paper(4.0), Some(4.0), TENTH).paper, Some(4.0));
        for expected in [reconstruction(4.0), requirement(4.0)] {
            let row = Row::near("a", "s", expected, Some(4.0), TENTH);
            assert_eq!((row.paper, row.expected), (None, Some(4.0)));
        }
    }

    #[test]
    fn every_compared_row_gives_the_reason_of_its_tolerance() {
        let json = serde_json::to_value(Row::near("a", "s", paper(4.0), None, TENTH));
        let json = json.expect("plain data");
        assert_eq!(
            (&json["kind"], &json["tolerance_reason"]),
            (&"paper".into(), &"a reason".into())
        );
        assert_eq!(json["check"], "near");
    }
}
