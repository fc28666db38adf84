//! Differences between laws, seed by seed, and which of them are real.
//!
//! Laws that met the same seeds are compared pair by pair: what a seed does to both falls out. An interval of
//! [`statistics::interval`] holds the difference without a guess at its distribution. Many differences are looked at
//! together, so each interval is widened until all of a scenario hold together (Bonferroni). A difference that does not
//! show in the figure's last digit is not called real. A drive that ended early has other figures. So pairs of completed runs alone count, and the share of completed runs is a figure of its own.

use report::figures::compared;
use report::gate::{self, Judged, Pairs};
use report::results::{Column, Good, count, number, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use supervise::report::Outcome;

use crate::row::Row;

/// Name of the share of completed runs.
const COMPLETED: &str = "completed";

pub fn columns() -> Vec<Column<Difference>> {
    vec![
        word("scenario", "scenario", ""),
        word("controller", "law", ""),
        word("", "figure", "").of(|difference| json!(difference.title)),
        number("mean", "difference", "", 3, ""),
        number("low", "from", "", 3, "").weight(1),
        number("high", "to", "", 3, "").weight(1),
        count("n", "n", "").weight(2),
        word("", "law is", "").of(|difference| json!(difference.judged.verdict())),
    ]
}

/// A figure of a law minus that of the first law, over the seeds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Difference {
    /// Scenario that was driven.
    pub scenario: String,
    /// Control law that drove.
    pub controller: String,
    /// The first law.
    pub reference: String,
    /// A key of `means.figures`, or `completed`.
    pub figure: &'static str,
    #[serde(skip)]
    pub title: String,
    #[serde(flatten)]
    pub judged: Judged,
    /// Differences of the scenario, which hold together.
    #[serde(skip)]
    family: usize,
}

/// Rule for a real difference, in words; `None` without differences.
pub fn rule(differences: &[Difference]) -> Option<String> {
    let largest = differences.iter().map(|difference| difference.family).max()?;
    let few = differences.iter().any(|difference| difference.judged.real.is_none());
    let first = format!("{} seed by seed, in pairs of completed runs", differences[0].reference);
    Some(gate::rule(&first, "a scenario", largest, few))
}

/// Every law against the first one, in each scenario; nothing for one seed.
pub fn differences(rows: &[Row]) -> Vec<Difference> {
    let scenarios = rows.chunk_by(|a, b| a.scenario == b.scenario);
    scenarios.flat_map(of_scenario).collect()
}

/// Every law since a baseline. `pairs` are runs of now with the same runs of before.
pub fn since(pairs: &[(&Row, &Row)]) -> Vec<Difference> {
    let scenarios = pairs.chunk_by(|a, b| a.0.scenario == b.0.scenario);
    let of_scenario = |pairs: &[(&Row, &Row)]| {
        let laws = pairs.chunk_by(|a, b| a.0.controller == b.0.controller);
        let all: Vec<Paired<'_>> = laws.flat_map(of_pairs).collect();
        let family = all.len();
        let judged = all.into_iter().map(|paired| paired.judged("baseline", family));
        judged.collect::<Vec<_>>()
    };
    scenarios.flat_map(of_scenario).collect()
}

/// Differences of one figure, before they are judged.
struct Paired<'a> {
    law: &'a Row,
    figure: &'static str,
    title: String,
    /// Values of the law and of the reference. Half of the last digit is the least difference.
    pairs: Pairs,
}

fn of_scenario(rows: &[Row]) -> Vec<Difference> {
    let laws: Vec<&[Row]> = rows.chunk_by(|a, b| a.controller == b.controller).collect();
    let Some((first, others)) = laws.split_first().filter(|(first, _)| first.len() > 1) else {
        return Vec::new();
    };
    let all: Vec<Paired<'_>> = others.iter().flat_map(|law| pairs(first, law)).collect();
    let family = all.len();
    all.into_iter().map(|paired| paired.judged(&first[0].controller, family)).collect()
}

/// The differences of a law from the first one, of each figure that both have in one seed at least.
fn pairs<'a>(first: &'a [Row], law: &'a [Row]) -> Vec<Paired<'a>> {
    // Parts of a comparison need not have all seeds of each law.
    let of_seed: BTreeMap<u64, &Row> = first.iter().map(|row| (row.seed, row)).collect();
    let rows: Vec<(&Row, &Row)> =
        law.iter().filter_map(|own| Some((own, *of_seed.get(&own.seed)?))).collect();
    of_pairs(&rows)
}

/// The differences in pairs of runs of one law with its reference.
fn of_pairs<'a>(rows: &[(&'a Row, &'a Row)]) -> Vec<Paired<'a>> {
    let Some((law, _)) = rows.first().copied() else { return Vec::new() };
    let completed = |row: &Row| f64::from(u8::from(row.outcome == Outcome::Completed));
    let shares = rows.iter().map(|(own, other)| [completed(own), completed(other)]);
    let shares = Paired {
        law,
        figure: COMPLETED,
        title: "share completed".to_owned(),
        pairs: Pairs { good: Good::More, shown: 0.0, values: shares.collect() },
    };
    let whole = rows.iter().filter(|(own, other)| completed(own) * completed(other) > 0.0);
    let whole: Vec<&(&Row, &Row)> = whole.collect();
    let of_figures = compared().filter(|figure| figure.good != Good::Neither);
    let of_figures = of_figures.map(|figure| Paired {
        law,
        figure: figure.name,
        title: figure.column::<()>().head.title(),
        pairs: Pairs {
            good: figure.good,
            shown: 0.5 / f64::from(10_u32.pow(figure.decimals as u32)),
            values: (whole.iter())
                .filter_map(|(own, other)| {
                    Some([own.figures.get(figure)?, other.figures.get(figure)?])
                })
                .collect(),
        },
    });
    std::iter::once(shares).chain(of_figures).filter(|one| !one.pairs.values.is_empty()).collect()
}

impl Paired<'_> {
    fn judged(self, reference: &str, family: usize) -> Difference {
        let Self { law, figure, title, pairs } = self;
        Difference {
            scenario: law.scenario.clone(),
            controller: law.controller.clone(),
            reference: reference.to_owned(),
            figure,
            title,
            judged: pairs.judged(family),
            family,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    /// Two laws over seeds, the second with a gap that is smaller by `less_m` in each.
    fn rows(seeds: u64, less_m: fn(u64) -> f64) -> Vec<Row> {
        let first = (1..=seeds).map(|seed| row("acc-mpc", seed, 20.0 + 3.0 * (seed % 4) as f64));
        let second = |seed| row("mine", seed, 20.0 + 3.0 * (seed % 4) as f64 - less_m(seed));
        first.chain((1..=seeds).map(second)).collect()
    }

    fn gap(differences: &[Difference]) -> &Difference {
        differences.iter().find(|difference| difference.figure == "min_gap_m").expect("a figure")
    }

    #[test]
    fn a_small_difference_in_every_seed_is_real_and_one_in_some_seeds_is_not() {
        // The seeds spread by 3 m, which the pairs do not see.
        let all = differences(&rows(12, |seed| 0.2 + 0.01 * (seed % 3) as f64));
        let difference = gap(&all);
        assert!(
            difference.judged.is_real() && difference.judged.better == Some(false),
            "{difference:?}"
        );
        assert!(
            difference.judged.low.expect("12 pairs") < difference.judged.mean,
            "{difference:?}"
        );
        let some = differences(&rows(12, |seed| if seed % 2 == 0 { 2.0 } else { -2.0 }));
        assert_eq!(
            (gap(&some).judged.real, gap(&some).judged.verdict()),
            (Some(false), "not real")
        );
        assert!(
            all.iter().filter(|other| other.judged.is_real()).count() == 1,
            "the rest is equal"
        );
    }

    #[test]
    fn too_few_seeds_are_named_with_the_number_that_is_needed() {
        let few = differences(&rows(5, |_| 1.0));
        assert_eq!((gap(&few).judged.real, gap(&few).judged.low), (None, None));
        let words = rule(&few).expect("there are differences");
        let least = statistics::least_pairs(0.05 / few.len() as f64).expect("a number has one");
        assert!(words.contains(&format!("Fewer than {least} pairs are too few")), "{words}");
        let enough = differences(&rows(least as u64, |_| 1.0));
        assert!(gap(&enough).judged.is_real());
        assert!(differences(&rows(1, |_| 1.0)).is_empty() && rule(&[]).is_none());
    }

    #[test]
    fn a_drive_that_ended_early_counts_as_such_alone() {
        let mut rows = rows(12, |_| 1.0);
        rows.iter_mut().skip(12).take(11).for_each(|row| row.outcome = Outcome::Collision);
        let all = differences(&rows);
        let share = all.iter().find(|difference| difference.figure == COMPLETED).expect("a figure");
        assert_eq!((share.judged.n, share.judged.verdict()), (12, "worse"), "{share:?}");
        assert_eq!((gap(&all).judged.n, gap(&all).judged.real), (1, None));
    }
}
