//! `timegap search`: scenes and faults that break a requirement, found before the road does.
//!
//! ```text
//! problem ─ method ─► points ─ reference avoids? ─► runs ─► values ─► method …
//!                                                      └─► failures ─► minimal cases ─► failure-1.toml
//! ```
//!
//! A [`problem::Problem`] is a scenario with variables and a requirement. A method ([`method`]) chooses points one
//! after the other; a [`mod@reference`] driver decides which are worth a run. Their value
//! ([`record`]) is made small: below 0 a run is a failure. The command is a study of `frame`: journals, parts and results are the frame's.
//!
//! docs/search.md has the files, the methods and what they found.

#![forbid(unsafe_code)]

pub mod distinct;
mod faults;
pub mod method;
pub mod minimal;
mod pictures;
pub mod probability;
pub mod problem;
pub mod record;
pub mod reference;
mod results;
mod rows;
mod study;

pub use results::schema;
pub use study::{STUDIES, first_violation, run};

use clap::Args;
use method::MethodName;
use reference::ReferenceName;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;
use supervise::{ScenarioOptions, UsageError};

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct SearchArguments {
    /// A search file (docs/search.md), or a scenario with --vary or --faults
    pub scenario: String,
    /// A key that varies: `KEY=A..B`, `KEY=A..B:log` or `KEY=a,b,c` (repeatable)
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<String>,
    /// Search faults instead of keys: try each fault of messages and timing, and show what it breaks
    #[arg(long, value_name = "WHICH", num_args = 0..=1, default_missing_value = "all", value_parser = ["all"],
        conflicts_with_all = ["vary", "method", "replicas", "cases"])]
    pub faults: Option<String>,
    /// Number of runs, without those for minimal cases
    #[arg(long, value_name = "N", default_value = "500")]
    pub budget: NonZeroUsize,
    /// Choice of the points
    #[arg(long, value_enum, default_value_t = MethodName::Gp)]
    pub method: MethodName,
    /// Independent searches that share the budget (`gp`); a part does whole ones
    #[arg(long, value_name = "N", default_value = "1")]
    pub replicas: NonZeroUsize,
    /// Seeds on which a minimal case is tried; it must fail on 80 % of them
    #[arg(long, value_name = "N", default_value = "10")]
    pub trials: NonZeroUsize,
    /// Failures that are reduced to minimal cases, 0 to 5
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=5))]
    pub cases: u8,
    /// Estimate how often the requirements are broken under the distributions of the file's `[probability]`
    #[arg(long, conflicts_with_all = ["faults", "method", "replicas"])]
    pub probability: bool,
    /// Driver that decides which scenes count: those that it avoids [default: regulation]
    #[arg(long, value_enum)]
    pub reference: Option<ReferenceName>,
    /// Options of all runs.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
}

impl SearchArguments {
    /// Seed of the study: the seeds of its runs come from it.
    pub fn seed(&self) -> Result<u64, UsageError> {
        match &self.scenario_options.seed {
            Some(seed) => {
                let expected = "a whole number without a sign";
                let number = seed.as_integer().and_then(|seed| seed.try_into().ok());
                number.ok_or_else(|| UsageError::option("--seed", seed, "no seed", expected))
            }
            None => Ok(1),
        }
    }
}
