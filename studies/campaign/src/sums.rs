//! Sums over all runs, and over runs with something in common.

use super::counts::Counts;
use super::measured::{Histograms, Measures};
use super::record::Record;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Runs of the same scenario, controller and fault.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Combination {
    pub scenario: String,
    pub controller: String,
    pub fault: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Runs with one thing in common.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Shared {
    /// The common scenario, controller or fault.
    pub of: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Sums over the runs: over all, and by what they have in common.
#[derive(Debug, Default)]
pub struct Sums {
    pub all: Sum,
    combinations: Grouped<3>,
    scenarios: Grouped<1>,
    controllers: Grouped<1>,
    faults: Grouped<1>,
}

/// Sums by names, in the order in which the names appear first.
#[derive(Debug)]
struct Grouped<const N: usize>(Vec<([String; N], Sum)>);

impl<const N: usize> Default for Grouped<N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<const N: usize> Grouped<N> {
    fn add(&mut self, names: [&str; N], record: &Record) {
        let known = self.0.iter().position(|(known, _)| known.each_ref() == names.each_ref());
        let place = known.unwrap_or_else(|| {
            self.0.push((names.map(str::to_owned), Sum::default()));
            self.0.len() - 1
        });
        self.0[place].1.add(record);
    }
}

impl Grouped<1> {
    fn shared(&self) -> Vec<Shared> {
        self.0.iter().map(|([of], sum)| Shared { of: of.clone(), tally: sum.tally() }).collect()
    }
}

impl Sums {
    /// Adds a run; they come in the order of their numbers.
    pub fn add(&mut self, record: &Record) {
        let Record { scenario, controller, fault, .. } = record;
        self.all.add(record);
        self.combinations.add([scenario, controller, fault], record);
        self.scenarios.add([scenario], record);
        self.controllers.add([controller], record);
        self.faults.add([fault], record);
    }

    /// By scenario, controller and fault.
    pub fn combinations(&self) -> Vec<Combination> {
        let combination = |([scenario, controller, fault], sum): &([String; 3], Sum)| {
            let [scenario, controller, fault] = [scenario, controller, fault].map(Clone::clone);
            Combination { scenario, controller, fault, tally: sum.tally() }
        };
        self.combinations.0.iter().map(combination).collect()
    }

    pub fn scenarios(&self) -> Vec<Shared> {
        self.scenarios.shared()
    }

    pub fn controllers(&self) -> Vec<Shared> {
        self.controllers.shared()
    }

    pub fn faults(&self) -> Vec<Shared> {
        self.faults.shared()
    }
}

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
