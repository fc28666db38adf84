//! Sums over all runs, and over runs with something in common.

use super::record::Record;
use super::tally::{Sum, Tally};
use schemars::JsonSchema;
use serde::Serialize;

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
