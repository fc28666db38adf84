//! `--against FILE`: an earlier result as the baseline, and what got worse since.
//!
//! ```text
//! samples of before ┐  pairs of the same run, row or block
//! samples of now ───┴─► now - before ─► interval leaves out 0, and shows in the figure's last digit: worse
//! ```
//!
//! The interval over the pairs is the figure's own noise ([`statistics::interval`]). Many figures are judged together, so
//! each interval is widened until all hold together (Bonferroni).

use crate::results::{Broken, Column, Document, Good, Table, count, number, word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statistics::{Interval, interval, least_pairs};
use std::path::{Path, PathBuf};
use supervise::UsageError;

/// Probability that one of a family of intervals misses its difference.
const TAILS: f64 = 0.05;

/// A figure in pairs: of now and before, or of a law and its reference.
#[derive(Debug)]
pub struct Pairs {
    pub good: Good,
    /// Least difference that is called real.
    pub shown: f64,
    pub values: Vec<[f64; 2]>,
}

/// The difference of a figure, over its pairs.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Judged {
    /// Mean of the reference over the pairs.
    pub before: f64,
    /// Mean of the differences.
    pub mean: f64,
    /// Interval of the difference; null of too few pairs.
    pub low: Option<f64>,
    pub high: Option<f64>,
    /// Pairs.
    pub n: usize,
    /// The interval leaves out 0; null of too few pairs.
    pub real: Option<bool>,
    /// Now is better than before; null where the difference is not real.
    pub better: Option<bool>,
}

impl Pairs {
    /// Judges the figure as one of `family` that hold together.
    pub fn judged(&self, family: usize) -> Judged {
        let n = self.values.len();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n as f64;
        let differences: Vec<f64> = self.values.iter().map(|[now, before]| now - before).collect();
        let by = mean(&mut differences.iter().copied());
        let found = interval(&differences, TAILS / family as f64);
        let is_real = |interval: &Interval| interval.leaves_out_zero() && by.abs() >= self.shown;
        let better = found.filter(is_real).map(|i| (i.low > 0.0) == (self.good == Good::More));
        Judged {
            before: mean(&mut self.values.iter().map(|[_, before]| *before)),
            mean: by,
            low: found.map(|interval| interval.low),
            high: found.map(|interval| interval.high),
            n,
            real: found.as_ref().map(is_real),
            better,
        }
    }
}

impl Judged {
    /// True if the difference is called real.
    pub fn is_real(&self) -> bool {
        self.real == Some(true)
    }

    /// The judgement in a word.
    pub fn verdict(&self) -> &'static str {
        match (self.real, self.better) {
            (None, _) => "too few pairs",
            (_, Some(true)) => "better",
            (_, Some(false)) => "worse",
            (_, None) => "not real",
        }
    }
}

/// The rule for a real difference, in words: `family` intervals of `what` hold together. With `few` pairs the least
/// number is named.
pub fn rule(from: &str, what: &str, family: usize, few: bool) -> String {
    let mut words = format!(
        "A difference is called real when its interval leaves out 0. It is taken from {from}. The {family} intervals of \
         {what} hold together with {} % (means of subsets, Hartigan 1969; Bonferroni). They assume that differences lie \
         symmetrically about their centre, and no more.",
        100.0 * (1.0 - TAILS)
    );
    if let Some(least) = least_pairs(TAILS / family as f64).filter(|_| few) {
        words += &format!(" Fewer than {least} pairs are too few for any.");
    }
    words
}

/// A figure of a result with a value for each run, row or block, in their order.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sample {
    /// Law, chain or paper that it is of.
    pub of: String,
    pub figure: String,
    pub values: Vec<Option<f64>>,
    #[serde(skip)]
    pub good: Good,
    /// Least difference that counts.
    #[serde(skip)]
    pub shown: f64,
    /// Each value that gets worse counts: it repeats exactly.
    #[serde(skip)]
    pub is_exact: bool,
}

impl Sample {
    /// A figure that is better the less it is. A growth by less than `factor` is not worse.
    pub fn growing(of: &str, figure: &str, values: Vec<Option<f64>>, factor: f64) -> Self {
        let found: Vec<f64> = values.iter().copied().flatten().collect();
        let mean = found.iter().sum::<f64>() / found.len().max(1) as f64;
        // Now is `factor` times what it was if the difference is this part of now.
        let shown = mean * (1.0 - 1.0 / factor);
        let (of, figure) = (of.to_owned(), figure.to_owned());
        Self { of, figure, values, good: Good::Less, shown, is_exact: false }
    }
}

/// An earlier result.
#[derive(Debug)]
pub struct Baseline {
    file: PathBuf,
    samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct Earlier {
    #[serde(default)]
    samples: Vec<Sample>,
}

/// Changes since a baseline.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Against {
    /// File of the baseline.
    pub baseline: String,
    /// Values that were good before and are not now, of figures that repeat exactly.
    pub broken: Vec<String>,
    pub differences: Vec<Change>,
    pub rule: String,
}

/// The change of a figure.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Change {
    /// Law, chain or paper.
    pub of: String,
    pub figure: String,
    #[serde(flatten)]
    pub judged: Judged,
}

impl Baseline {
    /// Reads a result of the same command, before anything runs.
    ///
    /// # Errors
    /// If the file is no such result.
    pub fn read(file: &Path, expected: &str) -> Result<Self, UsageError> {
        let refuse = |why: &dyn std::fmt::Display| {
            UsageError::option("--against", file.display(), why, expected)
        };
        let text = std::fs::read_to_string(file).map_err(|error| refuse(&error))?;
        let Earlier { samples } = serde_json::from_str(&text).map_err(|error| refuse(&error))?;
        if samples.is_empty() {
            return Err(refuse(&"it has no samples"));
        }
        Ok(Self { file: file.to_owned(), samples })
    }

    /// The figures of now against it.
    ///
    /// # Errors
    /// If it is of other runs.
    pub fn judge(&self, now: &[Sample]) -> Result<Against, UsageError> {
        let refuse = |why: String| {
            let expected = "a result of the same runs";
            UsageError::option("--against", self.file.display(), why, expected)
        };
        let (mut paired, mut broken) = (Vec::new(), Vec::new());
        for sample in now {
            let Sample { of, figure, .. } = sample;
            let is_same = |before: &&Sample| (&before.of, &before.figure) == (of, figure);
            let Some(before) = self.samples.iter().find(is_same) else { continue };
            let [own, other] = [sample.values.len(), before.values.len()];
            if own != other {
                return Err(refuse(format!("{figure} of {of} has {other} values, and now {own}")));
            }
            let both = sample.values.iter().zip(&before.values);
            let pairs =
                both.enumerate().filter_map(|(n, (now, was))| Some((n, [(*now)?, (*was)?])));
            let pairs: Vec<(usize, [f64; 2])> = pairs.collect();
            let sign = if sample.good == Good::More { -1.0 } else { 1.0 };
            let is_worse = |[now, was]: &[f64; 2]| sign * (now - was) > sample.shown;
            if sample.is_exact {
                let worse = pairs.iter().filter(|(_, pair)| is_worse(pair));
                broken.extend(worse.map(|(n, [now, was])| {
                    format!("{of}, {}: {figure} is {now}, was {was}", n + 1)
                }));
            }
            let values = pairs.into_iter().map(|(_, pair)| pair).collect::<Vec<_>>();
            if !values.is_empty() {
                paired.push((sample, Pairs { good: sample.good, shown: sample.shown, values }));
            }
        }
        let family = paired.len();
        if let (0, Some(first)) = (family, self.samples.first()) {
            return Err(refuse(format!("its first figure is {} of {}", first.figure, first.of)));
        }
        let change = |(sample, pairs): (&Sample, Pairs)| Change {
            of: sample.of.clone(),
            figure: sample.figure.clone(),
            judged: pairs.judged(family),
        };
        let differences: Vec<Change> = paired.into_iter().map(change).collect();
        let few = differences.iter().any(|change| change.judged.real.is_none());
        let baseline = self.file.display().to_string();
        let rule = rule("the baseline, pair by pair", "all figures", family, few);
        Ok(Against { baseline, broken, differences, rule })
    }
}

impl Against {
    fn worse(&self) -> impl Iterator<Item = &Change> {
        self.differences.iter().filter(|change| change.judged.better == Some(false))
    }

    /// True if nothing got worse.
    pub fn holds(&self) -> bool {
        self.broken.is_empty() && self.worse().next().is_none()
    }

    /// The result with what got worse: it alone decides verdict and status.
    pub fn onto(&self, mut document: Document) -> Document {
        let worse: Vec<&Change> = self.worse().collect();
        let mut words = format!("against {}: {} figures are worse", self.baseline, worse.len());
        let few = self.differences.iter().filter(|change| change.judged.real.is_none()).count();
        if few > 0 {
            words += &format!(", {few} have too few pairs to be judged");
        }
        let found = worse.iter().map(|change| {
            let Change { of, figure, judged } = change;
            format!("{of}: {figure} is worse by {:.3}, was {:.3}", judged.mean.abs(), judged.before)
        });
        let found: Vec<String> = found.chain(self.broken.iter().cloned()).collect();
        document = document.judged_anew(self.holds(), &words);
        let columns: [Column<Change>; 8] = [
            word("of", "of", "Law, chain or paper"),
            word("figure", "figure", "Figure"),
            number("before", "before", "", 3, "Mean of the baseline"),
            number("mean", "difference", "", 3, "Mean of now minus before"),
            number("low", "from", "", 3, "Lower end of its interval").weight(1),
            number("high", "to", "", 3, "Upper end of its interval").weight(1),
            count("n", "n", "Pairs").weight(2),
            word("", "is", "Judgement").of(|change| change.judged.verdict().into()),
        ];
        document
            .table(Table::new("Worse than the baseline", &columns, worse))
            .table(
                Table::new("All changes since the baseline", &columns, &self.differences)
                    .for_pages()
                    .without_cases(),
            )
            .text(self.rule.clone())
            .broken(found.into_iter().map(|what| Broken::new(what, "")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(values: &[f64], is_exact: bool) -> Sample {
        let values = values.iter().copied().map(Some).collect();
        let (of, figure) = ("mine".to_owned(), "gap".to_owned());
        Sample { of, figure, values, good: Good::More, shown: 0.05, is_exact }
    }

    fn judge(now: Sample, before: &[f64]) -> Result<Against, UsageError> {
        let samples = vec![sample(before, false)];
        Baseline { file: "base.json".into(), samples }.judge(&[now])
    }

    #[test]
    fn a_loss_in_every_pair_is_worse_and_one_within_the_noise_is_not() {
        let before: Vec<f64> = (0..12).map(|n| 20.0 + f64::from(n % 4)).collect();
        let by = |each: fn(usize) -> f64| {
            let now: Vec<f64> = before.iter().enumerate().map(|(n, was)| was + each(n)).collect();
            judge(sample(&now, false), &before).expect("the same runs")
        };
        assert!(by(|_| 0.0).holds() && by(|_| 0.3).holds() && by(|_| -0.01).holds());
        assert!(by(|n| if n % 2 == 0 { 0.5 } else { -0.5 }).holds());
        let worse = by(|_| -0.3);
        assert!(!worse.holds());
        let document = worse.onto(Document::new("x", "X", &()).verdict(true, "fine"));
        assert!(!document.is_ok() && document.junit().contains("<failure"));
        assert!(document.console(100).contains("against base.json: 1 figures are worse"));
        assert!(document.markdown().contains("Worse than the baseline"));
    }

    #[test]
    fn one_loss_of_a_figure_that_repeats_exactly_is_worse() {
        let against = judge(sample(&[1.0, 1.0, 0.0], true), &[1.0; 3]).expect("the same runs");
        assert_eq!(against.broken, ["mine, 3: gap is 0, was 1"]);
        assert!(!against.holds() && against.differences[0].judged.real.is_none());
        let document = against.onto(Document::new("x", "X", &()).verdict(true, "fine"));
        assert!(document.console(100).contains("1 have too few pairs to be judged"));
    }

    #[test]
    fn other_runs_are_refused_with_what_is_there() {
        let said = judge(sample(&[1.0], false), &[1.0, 2.0]).expect_err("other runs").to_string();
        assert!(said.contains("gap of mine has 2 values, and now 1"), "{said}");
        let other = Sample { of: "other".into(), ..sample(&[1.0], false) };
        let said = judge(other, &[1.0]).expect_err("another law").to_string();
        assert!(said.contains("its first figure is gap of mine"), "{said}");
    }
}
