//! Columns of requirements' verdicts, for the results of studies.

use super::results::{Column, count, flag, number, word};
use crate::print;
use serde::Serialize;
use supervise::RequirementVerdict;

/// Columns of a run's verdicts on its requirements.
pub fn columns<R>() -> [Column<R>; 6] {
    [
        word("requirement", "requirement", "The requirement as it was given"),
        word("formula", "", "Its formula, or its rule in words").hidden(),
        number("margin", "margin", "", 2, "Distance to violation; null where nothing decides it"),
        word("unit", "unit", "Unit of the margin"),
        number("at_s", "at", "s", 2, "Run time of the instant that decides it"),
        flag("met", "", ("met", "broken"), "The requirement holds"),
    ]
}

/// The verdicts in words, for a cell of a table; `None` without a requirement.
pub fn words(verdicts: &[RequirementVerdict]) -> Option<String> {
    let each = verdicts
        .iter()
        .map(|verdict| format!("{}: {}", verdict.requirement, print::requirement(verdict)));
    (!verdicts.is_empty()).then(|| each.collect::<Vec<_>>().join("; "))
}

/// A requirement over several runs: its least margin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Least {
    /// The verdict of the run that decides.
    #[serde(flatten)]
    pub verdict: RequirementVerdict,
    /// Runs that were judged.
    pub runs: usize,
    /// Runs that broke it.
    pub broken: usize,
    pub run: String,
}

/// Columns of requirements over several runs.
pub const LEAST: &[Column<Least>] = &[
    word("requirement", "requirement", "The requirement as it was given"),
    word("formula", "", "Its formula, or its rule in words").hidden(),
    number("margin", "least margin", "", 2, "Least margin of all runs; null where nothing decides"),
    word("unit", "unit", "Unit of the margin"),
    number("at_s", "at", "s", 2, "Run time of the instant that decides it"),
    word("run", "in", "Run with the least margin"),
    count("runs", "runs", "Runs that were judged"),
    count("broken", "broken", "Runs that broke it"),
    flag("met", "verdict", ("met", "BROKEN"), "The requirement holds in all runs"),
];

/// The least margin of each requirement over runs, which have a name each.
pub fn least<'a>(runs: impl IntoIterator<Item = (String, &'a [RequirementVerdict])>) -> Vec<Least> {
    let mut all: Vec<Least> = Vec::new();
    let runs = runs.into_iter();
    for (run, verdict) in runs.flat_map(|(run, all)| all.iter().map(move |one| (run.clone(), one)))
    {
        let known = all.iter_mut().find(|least| least.verdict.requirement == verdict.requirement);
        let Some(least) = known else {
            let broken = usize::from(!verdict.met);
            all.push(Least { verdict: verdict.clone(), runs: 1, broken, run });
            continue;
        };
        least.runs += 1;
        least.broken += usize::from(!verdict.met);
        if is_less(verdict, &least.verdict) {
            (least.verdict, least.run) = (verdict.clone(), run);
        }
    }
    all
}

/// A broken requirement comes before one that is met; then the smaller margin does.
fn is_less(one: &RequirementVerdict, other: &RequirementVerdict) -> bool {
    // A drive without a sample breaks it and has no margin.
    let undecided =
        |of: &RequirementVerdict| if of.met { f64::INFINITY } else { f64::NEG_INFINITY };
    let key = |of: &RequirementVerdict| of.margin.unwrap_or_else(|| undecided(of));
    (one.met, key(one)) < (other.met, key(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(margin: Option<f64>, met: bool) -> [RequirementVerdict; 1] {
        let (requirement, formula, unit) = ("x".into(), "x".into(), "m".into());
        [RequirementVerdict { requirement, formula, margin, unit, at_s: 1.0, met }]
    }

    #[test]
    fn the_least_margin_decides_over_all_runs() {
        let of = |all: &[(&str, [RequirementVerdict; 1])]| {
            least(all.iter().map(|(run, all)| ((*run).to_owned(), all.as_slice()))).remove(0)
        };
        let [a, b, c] = [(Some(2.0), true), (Some(0.5), true), (None, true)];
        let all = [a, b, c].map(|(margin, met)| verdict(margin, met));
        let [a, b, c] = all;
        let found = of(&[("a", a.clone()), ("b", b.clone()), ("c", c.clone())]);
        assert_eq!((found.run.as_str(), found.runs, found.broken), ("b", 3, 0));
        // A conjunction of units in tolerances may be broken with the larger number.
        let broken = verdict(Some(1.0), false);
        let found = of(&[("c", c), ("b", b), ("broken", broken), ("a", a)]);
        assert_eq!((found.run.as_str(), found.broken, found.verdict.met), ("broken", 1, false));
        assert_eq!(least(std::iter::empty()), []);
    }
}
