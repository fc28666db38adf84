//! The arguments of `search`.

use std::num::NonZeroUsize;

use clap::Args;
use frame::parts::{self, PartOptions};
use group::{GroupOptions, ScenarioOptions};
use report::results::ResultOptions;

use crate::method::MethodName;
use crate::reference::ReferenceName;

/// Options that a merge takes from the parts.
const WITHOUT_MERGE: [&str; 15] = [
    "scenario",
    "vary",
    "budget",
    "method",
    "replicas",
    "seeds",
    "cases",
    "reference",
    "controller",
    "laws",
    "seed",
    "duration",
    "set",
    "require",
    "jobs",
];

/// Arguments of `search`.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("merge", |merge| merge.conflicts_with_all(WITHOUT_MERGE).conflicts_with_all(parts::OF_RUNS)))]
pub struct SearchArguments {
    /// A search file (docs/search.md), or a scenario with --vary or --faults
    #[arg(required_unless_present_any = ["merge", "resume"])]
    pub scenario: Option<String>,
    /// A key that varies: `KEY=A..B`, `KEY=A..B:log` or `KEY=a,b,c` (repeatable)
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<String>,
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
    pub seeds: NonZeroUsize,
    /// Failures that are reduced to minimal cases, 0 to 5
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=5))]
    pub cases: u8,
    /// Driver who must be able to avoid a scene that counts [default: regulation]
    #[arg(long, value_enum)]
    pub reference: Option<ReferenceName>,
    /// Options of all runs.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    /// Runs at once [default: one per core]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Parts of the search.
    #[command(flatten)]
    pub parts: PartOptions,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}
