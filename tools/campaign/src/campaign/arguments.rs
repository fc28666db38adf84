//! What the command is told.

use crate::parts::ShardChoice;
use clap::Args;
use group::GroupOptions;
use report::output::OutputOptions;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(
    after_help = "Built-in campaigns: kills, messages, restarts, soak, takeovers. `plausibility` prints how often and how \
fast the controller's checks of its inputs find a false sender, `radio` what becomes of frames that are lost, late \
and falsified (2,000 runs, or --sample N from --first M on)."
)]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Begin with run number N: `radio` alone
    #[arg(long, value_name = "N")]
    pub first: Option<NonZeroUsize>,
    /// Runs of every combination, instead of what the file says
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Do only part I of N of the runs, or the part that the array job's environment names (`auto`,
    /// or `auto/N` where that does not tell the number); `--merge` puts the parts together
    #[arg(long, value_name = "I/N|auto")]
    pub shard: Option<ShardChoice>,
    /// Go on with the campaign in this directory; begin it there if there is none
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Put the shards in these directories together
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["campaign", "seeds", "sample", "first", "shard", "resume"])]
    pub merge: Vec<PathBuf>,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which form.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the verdict as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}
