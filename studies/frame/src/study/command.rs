//! The command lines of a study, of `merge` and of `resume`.

use crate::keep::Keep;
use crate::parts::{Shard, ShardChoice};
use clap::{Args, FromArgMatches};
use report::results::ResultOptions;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use supervise::GroupOptions;

/// The command line of a study: what it asks, and how that is done.
#[derive(Clone, Debug, Args)]
pub struct Command<A: Args> {
    /// Arguments of the study.
    #[command(flatten)]
    pub study: A,
    /// How it is done.
    #[command(flatten)]
    pub options: RunOptions,
}

impl<A: Args> Command<A> {
    /// Reads the words of a command line, without those of its name.
    pub fn read(words: &[&str]) -> Result<Self, clap::Error> {
        let command = Self::augment_args(clap::Command::new("study").no_binary_name(true));
        Self::from_arg_matches(&command.try_get_matches_from(words)?)
    }
}

/// How the runs of a study are done, and the place and forms of its results.
#[derive(Clone, Debug, Args)]
pub struct RunOptions {
    /// Do part I of N of the runs; `auto` takes both from the array job's environment, `auto/N` only I; see `merge`
    #[arg(long, value_name = "I/N|auto")]
    pub shard: Option<ShardChoice>,
    /// Do the study in this directory: go on with the same study there, or begin it
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Keep the trajectories of runs in trajectories.parquet: all, failures, or worst:N by the smallest gap
    #[arg(long, value_name = "WHICH", conflicts_with = "resume")]
    pub keep: Option<Keep>,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Repeat some of the runs in process groups too: they must give the same bytes
    #[arg(long, conflicts_with = "processes")]
    pub verify_processes: bool,
    /// Start of each run's processes.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}

#[derive(Clone, Debug, Args)]
pub struct MergeArguments {
    /// Directories of the parts
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}

#[derive(Clone, Debug, Args)]
#[command(mut_arg("out", |out| out.requires("shard")))]
pub struct ResumeArguments {
    /// Directory of a study, or of a part of one, that was interrupted
    pub directory: PathBuf,
    /// Do this other part of the study, in a directory of its own (`--out`)
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}
