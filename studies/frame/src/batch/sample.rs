//! The runs that are repeated in process groups: the evidence for all runs in memory.

use group::{Failure, Status};
use indicatif::ProgressBar;
use rand_core::Rng;
use rand_pcg::Pcg32;
use report::summary::Summary;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeSet;

/// One run in this number is repeated.
const EVERY: usize = 200;
/// Least number of repeated runs, as far as there are enough.
const LEAST: usize = 3;
/// Random sequence of the choice.
const STREAM: u64 = 0x5a3e;

/// A run in one process and the same run in a process group gave different bytes.
#[derive(Debug, thiserror::Error)]
#[error("run {run}{what} in a process group: {why}")]
pub struct OtherBytes {
    run: usize,
    /// Words on the run.
    what: String,
    /// The difference.
    why: String,
}

impl Failure for OtherBytes {
    fn status(&self) -> Status {
        Status::Different
    }
}

/// Result of repeating a run in a process group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Repetition {
    /// The same bytes.
    Same,
    /// The difference.
    Different(String),
}

impl Repetition {
    /// A result that is read back: only whether the bytes were the same is known.
    pub fn of_same(same: bool) -> Self {
        if same { Self::Same } else { Self::Different("other bytes in a process group".to_owned()) }
    }
}

/// Results of the repeated runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ProcessesSample {
    /// Runs that were repeated.
    pub runs: usize,
    /// Repeated runs whose messages were other bytes.
    pub different: usize,
    /// The first of them that was noticed: its index and the difference.
    #[serde(skip)]
    pub first_difference: Option<(usize, String)>,
}

impl ProcessesSample {
    /// Counts the repetition of run `index`; nothing if it was not repeated.
    pub fn count(&mut self, index: usize, repetition: Option<&Repetition>) {
        let Some(repetition) = repetition else { return };
        self.runs += 1;
        if let Repetition::Different(why) = repetition {
            self.different += 1;
            self.first_difference.get_or_insert_with(|| (index, why.clone()));
        }
    }

    /// The sample, if every repeated run gave the same bytes. `describe` gives words on a run.
    ///
    /// # Errors
    /// [`OtherBytes`] if one of them gave other bytes.
    pub fn agreed(self, describe: impl Fn(usize) -> String) -> Result<Self, OtherBytes> {
        match &self.first_difference {
            None => Ok(self),
            Some((run, why)) => {
                Err(OtherBytes { run: *run, what: describe(*run), why: why.clone() })
            }
        }
    }

    /// Reports on standard error how many of `all` runs were repeated, with the result.
    pub fn print(&self, all: usize, bar: &ProgressBar) {
        let found = match self.different {
            0 => "the same bytes".to_owned(),
            different => format!("{different} gave other bytes"),
        };
        if self.runs > 0 {
            let runs = self.runs;
            bar.suspend(|| {
                eprintln!("{runs} of {all} runs were repeated in process groups: {found}");
            });
        }
    }
}

/// The runs to repeat, of `runs` in all.
///
/// ```
/// let chosen = frame::batch::choose(1, 1_000);
/// assert_eq!(chosen.len(), 5, "one in 200");
/// assert_eq!(chosen, frame::batch::choose(1, 1_000), "the seed decides");
/// ```
#[must_use]
pub fn choose(seed: u64, runs: usize) -> BTreeSet<usize> {
    let wanted = runs.div_ceil(EVERY).max(LEAST).min(runs);
    let mut random = Pcg32::new(seed, STREAM);
    let mut chosen = BTreeSet::new();
    // Floyd's algorithm: every subset is as likely as any other, up to the remainder's 2^-64 or so.
    for last in runs - wanted..runs {
        let index = usize::try_from(random.next_u64() % (last as u64 + 1)).expect("an index");
        if !chosen.insert(index) {
            chosen.insert(last);
        }
    }
    chosen
}

/// The difference of two runs of the same scenario: the first topic, the outcome, or a figure of the drive.
pub(super) fn difference(one: &Summary, other: &Summary) -> Option<String> {
    let topics: BTreeSet<&String> = one.messages.keys().chain(other.messages.keys()).collect();
    let digests = |summary: &Summary, topic: &String| {
        summary.messages.get(topic).map(|counts| counts.digests.clone()).unwrap_or_default()
    };
    let topic = topics.into_iter().find(|topic| digests(one, topic) != digests(other, topic));
    topic
        .map(|topic| format!("other bytes on {topic}"))
        .or_else(|| {
            (one.outcome != other.outcome).then(|| {
                format!("{:?} in one process, {:?} in a group", one.outcome, other.outcome)
            })
        })
        .or_else(|| figure_that_differs(&control(one), &control(other)))
}

fn control(summary: &Summary) -> Map<String, Value> {
    match serde_json::to_value(&summary.control) {
        Ok(Value::Object(figures)) => figures,
        other => unreachable!("the figures are an object of plain data: {other:?}"),
    }
}

/// The first figure of the drive that is not the same number, with both.
fn figure_that_differs(one: &Map<String, Value>, other: &Map<String, Value>) -> Option<String> {
    let names: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
    let name = names.into_iter().find(|name| one.get(*name) != other.get(*name))?;
    let shown = |figures: &Map<String, Value>| {
        figures.get(name).map_or_else(|| "missing".to_owned(), Value::to_string)
    };
    Some(format!("control.{name} is {} in one process, {} in a group", shown(one), shown(other)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_in_two_hundred_and_at_least_three_are_chosen_by_the_seed() {
        for (runs, wanted) in [(0, 0), (2, 2), (3, 3), (600, 3), (601, 4), (10_000, 50)] {
            let chosen = choose(1, runs);
            assert_eq!(chosen.len(), wanted, "of {runs}");
            assert!(chosen.iter().all(|&index| index < runs));
            assert_eq!(chosen, choose(1, runs));
        }
        assert_ne!(choose(1, 10_000), choose(2, 10_000));
    }

    #[test]
    fn a_figure_that_differs_is_named_with_both_values() {
        let figures = |gap: f64| match serde_json::json!({"min_gap_m": gap, "min_ttc_s": null}) {
            Value::Object(figures) => figures,
            other => panic!("{other}"),
        };
        assert_eq!(figure_that_differs(&figures(2.5), &figures(2.5)), None);
        let said = figure_that_differs(&figures(2.5), &figures(2.75)).expect("another gap");
        assert_eq!(said, "control.min_gap_m is 2.5 in one process, 2.75 in a group");
    }

    #[test]
    fn every_run_is_as_likely_to_be_chosen() {
        let mut counts = [0; 20];
        for seed in 0..4_000 {
            choose(seed, 20).into_iter().for_each(|index| counts[index] += 1);
        }
        // 600 expected of each, standard deviation 22.6.
        assert!(counts.iter().all(|count| (480..720).contains(count)), "{counts:?}");
    }
}
