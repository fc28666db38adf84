//! `--against FILE`: an earlier comparison as the baseline, and what got worse since.
//!
//! ```text
//! compare.json of before ─► rows ┐  pairs of the same scenario, law and seed
//! rows of now ───────────────────┴─► now - before ─► interval leaves out 0, and shows in the figure's last digit: worse
//! ```
//!
//! The interval over the seeds is the figure's own noise. A run that completed before and does not complete now is
//! worse in any case.

use report::results::{Table, count, number, word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use supervise::UsageError;
use supervise::report::Outcome;

use super::differences::{Difference, columns, rule, since};
use crate::row::Row;

/// The content that a baseline must have.
const EXPECTED: &str = "the compare.json of an earlier comparison";

/// The runs of an earlier comparison.
#[derive(Debug)]
pub struct Baseline {
    file: PathBuf,
    rows: Vec<Row>,
}

/// The part of a comparison's result that a baseline needs.
#[derive(Deserialize)]
struct Earlier {
    #[serde(default)]
    rows: Vec<Row>,
}

/// A run that completed before and does not complete now.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Broken {
    /// Scenario that was driven.
    pub scenario: String,
    /// Control law that drove.
    pub controller: String,
    /// Seed of the run.
    pub seed: u64,
    /// How it ends now.
    #[schemars(with = "String")]
    pub outcome: Outcome,
}

/// The runs against those of a baseline.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Against {
    /// File of the baseline.
    pub baseline: String,
    /// Runs that have a partner in the baseline.
    pub pairs: usize,
    /// Runs of the baseline that were not driven again.
    pub missing: usize,
    /// Runs that completed before and do not complete now.
    pub broken: Vec<Broken>,
    /// Each figure of each law, now minus before.
    pub differences: Vec<Difference>,
    /// Rule for a real difference; null without pairs of completed runs.
    pub rule: Option<String>,
}

/// Name of a run within a comparison.
fn name(row: &Row) -> (&str, &str, u64) {
    (&row.scenario, &row.controller, row.seed)
}

impl Baseline {
    /// Reads a baseline.
    ///
    /// # Errors
    /// If the file is not the result of a comparison.
    pub fn read(file: &Path) -> Result<Self, UsageError> {
        let refuse = |why: &dyn std::fmt::Display| {
            UsageError::option("--against", file.display(), why, EXPECTED)
        };
        let text = std::fs::read_to_string(file).map_err(|error| refuse(&error))?;
        let Earlier { rows } = serde_json::from_str(&text).map_err(|error| refuse(&error))?;
        if rows.is_empty() {
            return Err(refuse(&"it has no rows"));
        }
        let rows = rows.into_iter().map(Row::with_figures).collect();
        Ok(Self { file: file.to_owned(), rows })
    }

    /// The runs `now` against it.
    ///
    /// # Errors
    /// If no run has a partner in the baseline.
    pub fn judge(&self, now: &[Row]) -> Result<Against, UsageError> {
        let before: BTreeMap<_, &Row> = self.rows.iter().map(|row| (name(row), row)).collect();
        let partner = |row: &Row| before.get(&name(row)).copied();
        let pairs: Vec<(&Row, &Row)> =
            now.iter().filter_map(|row| Some((row, partner(row)?))).collect();
        if pairs.is_empty() {
            let (scenario, law, seed) = name(&self.rows[0]);
            let why = format!("its first run is {scenario}, {law}, seed {seed}");
            let expected = "a run of these scenarios, laws and seeds";
            return Err(UsageError::option("--against", self.file.display(), why, expected));
        }
        let ends_worse = |(row, before): &&(&Row, &Row)| {
            before.outcome == Outcome::Completed && row.outcome != Outcome::Completed
        };
        let broken = pairs.iter().filter(ends_worse).map(|(row, _)| Broken {
            scenario: row.scenario.clone(),
            controller: row.controller.clone(),
            seed: row.seed,
            outcome: row.outcome,
        });
        let differences = since(&pairs);
        Ok(Against {
            baseline: self.file.display().to_string(),
            pairs: pairs.len(),
            missing: self.rows.len() - pairs.len(),
            broken: broken.collect(),
            rule: rule(&differences),
            differences,
        })
    }
}

impl Against {
    /// The figures that got worse.
    fn worse(&self) -> impl Iterator<Item = &Difference> {
        self.differences.iter().filter(|difference| difference.judged.better == Some(false))
    }

    /// True if nothing got worse.
    pub fn holds(&self) -> bool {
        self.broken.is_empty() && self.worse().next().is_none()
    }

    pub fn verdict(&self) -> String {
        let Self { baseline, pairs, missing, broken, .. } = self;
        let worse = self.worse().count();
        let mut words = format!("against {baseline}: {worse} figures are worse");
        if !broken.is_empty() {
            words += &format!(", {} runs do not complete any more", broken.len());
        }
        words += &format!(" ({pairs} pairs of runs");
        if *missing > 0 {
            words += &format!("; {missing} runs of the baseline were not driven");
        }
        words + ")"
    }

    /// What got worse, then all differences for pages.
    pub fn tables(&self) -> Vec<Table> {
        let mut columns = columns();
        columns.insert(3, number("before", "before", "", 3, ""));
        let broken = [
            word("scenario", "scenario", ""),
            word("controller", "law", ""),
            count("seed", "seed", ""),
            report::results::outcome("outcome"),
        ];
        let worse: Vec<&Difference> = self.worse().collect();
        let all: Vec<&Difference> = self.differences.iter().collect();
        vec![
            Table::new("Runs that completed before", &broken, &self.broken),
            Table::new("Worse than the baseline", &columns, worse),
            Table::new("All changes since the baseline", &columns, all).for_pages().without_cases(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    fn rows(less_m: f64) -> Vec<Row> {
        (1..=12).map(|seed| row("acc-mpc", seed, 20.0 + 3.0 * (seed % 4) as f64 - less_m)).collect()
    }

    fn judge(now: &[Row]) -> Against {
        let baseline = Baseline { file: "base.json".into(), rows: rows(0.0) };
        baseline.judge(now).expect("the same runs")
    }

    #[test]
    fn equal_runs_hold_and_a_smaller_gap_is_worse_whatever_the_seeds_spread() {
        assert!(judge(&rows(0.0)).holds());
        let worse = judge(&rows(0.2));
        assert!(!worse.holds());
        assert_eq!(worse.worse().map(|found| found.figure).collect::<Vec<_>>(), ["min_gap_m"]);
        assert!(worse.verdict().starts_with("against base.json: 1 figures are worse (12 pairs"));
        assert!(judge(&rows(-0.2)).holds(), "a larger gap is better");
        assert!(judge(&rows(0.004)).holds(), "it does not show in the figure's last digit");
    }

    #[test]
    fn a_run_that_does_not_complete_any_more_is_worse() {
        let mut now = rows(0.0);
        now[3].outcome = Outcome::Collision;
        let against = judge(&now);
        assert!(!against.holds());
        assert_eq!((against.broken.len(), against.broken[0].seed), (1, 4));
        let few = judge(&now[..4]);
        assert_eq!((few.missing, few.broken.len(), few.holds()), (8, 1, false));
    }

    #[test]
    fn a_file_that_is_no_comparison_is_refused_with_its_name() {
        let folder = std::env::temp_dir().join(format!("against-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join("b.json");
        let said = |text: &str| {
            std::fs::write(&file, text).expect("written");
            Baseline::read(&file).expect_err("refused").to_string()
        };
        assert!(said("{").contains("b.json: EOF"), "{}", said("{"));
        assert!(said("{\"rows\": []}").contains("it has no rows"));
        assert!(said("{\"rows\": [{}]}").contains("missing field"));
        let baseline = Baseline { file: file.clone(), rows: rows(0.0) };
        let other = [row("six-mode", 1, 20.0)];
        let said = baseline.judge(&other).expect_err("another law").to_string();
        assert!(said.contains("its first run is following, acc-mpc, seed 1"), "{said}");
        std::fs::remove_dir_all(folder).expect("it was made");
    }
}
