//! Sums over runs.

use super::counts::Counts;
use super::measured::{Histograms, Measures};
use super::record::Record;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Sums over some runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Tally {
    #[serde(flatten)]
    pub counts: Counts,
    #[serde(flatten)]
    pub measures: Measures,
    /// Faults that acted in each phase.
    pub phases: BTreeMap<String, u64>,
    /// Received radio frames by the on-board unit's verdict.
    pub frames: BTreeMap<String, u64>,
    /// Time of each service on each degradation level, s.
    pub rungs_s: BTreeMap<String, f64>,
    /// The service whose memory grew most.
    pub memory_growth_of: String,
}

/// Sums while runs are added.
#[derive(Debug, Default)]
pub struct Sum {
    tally: Tally,
    pub histograms: Histograms,
}

impl Sum {
    /// Adds a run. In another order the times on the levels may differ in their last digits.
    pub fn add(&mut self, record: &Record) {
        let (tally, found) = (&mut self.tally, &record.measured);
        for (sum, found) in [(&mut tally.phases, &found.phases), (&mut tally.frames, &found.frames)]
        {
            for (name, count) in found {
                *sum.entry(name.clone()).or_insert(0) += count;
            }
        }
        for (rung, time_s) in &found.rungs_s {
            *tally.rungs_s.entry(rung.clone()).or_insert(0.0) += time_s;
        }
        let most_kib = tally.measures.extremes.memory_growth_kib;
        if let Some(growth) = &found.growth
            && most_kib.is_none_or(|most| growth.memory_kib > most)
        {
            tally.memory_growth_of.clone_from(&growth.memory_of);
        }
        tally.counts.add(record);
        tally.measures.extremes.add(record);
        self.histograms.add(record);
    }

    /// The sums over the runs so far.
    pub fn tally(&self) -> Tally {
        let mut tally = self.tally.clone();
        tally.measures.times = self.histograms.times();
        tally
    }
}
