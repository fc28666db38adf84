//! A drive of a population.

use report::figures::{self, Values};
use serde::{Deserialize, Serialize};
use supervise::RequirementVerdict;
use supervise::report::Outcome;

/// A drive of a population, before it is driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    pub number: usize,
    /// Law that drives; empty: the scene's own.
    pub law: String,
    /// Values of the population's keys.
    pub keys: Vec<String>,
}

impl Planned {
    /// The drive in words.
    pub fn name(&self) -> String {
        let keys = self.keys.iter().filter(|key| !key.is_empty());
        let keys: Vec<&str> = keys.map(String::as_str).collect();
        let name = format!("{} {}", keys.join(" "), self.number);
        let law = if self.law.is_empty() { String::new() } else { format!(", {}", self.law) };
        format!("{}{law}", name.trim())
    }
}

/// A drive and what the judge found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Drive<F> {
    #[serde(flatten)]
    pub planned: Planned,
    pub outcome: Outcome,
    pub aborted_because: Option<String>,
    pub duration_s: f64,
    pub figures: Values,
    pub requirements: Vec<RequirementVerdict>,
    #[serde(flatten)]
    pub facts: F,
}

impl<F> Drive<F> {
    /// Interventions of the emergency brake.
    pub fn interventions(&self) -> u64 {
        self.figures.get(&figures::INTERVENTIONS).map_or(0, |times| times as u64)
    }

    /// How the run ended, in words.
    pub fn outcome_words(&self) -> String {
        let word = report::print::outcome_word(self.outcome).to_lowercase();
        self.aborted_because.as_ref().map_or_else(|| word.clone(), |why| format!("{word}: {why}"))
    }

    #[cfg(test)]
    pub fn example(law: &str, keys: &[&str], facts: F) -> Self {
        let keys = keys.iter().map(|key| (*key).to_owned()).collect();
        Self {
            planned: Planned { number: 1, law: law.to_owned(), keys },
            outcome: Outcome::Completed,
            aborted_because: None,
            duration_s: 1_800.0,
            figures: Values::default(),
            requirements: Vec::new(),
            facts,
        }
    }
}
