//! The arguments of `campaign`.

use clap::Args;
use frame::parts::PartOptions;
use group::GroupOptions;
use report::output::OutputOptions;
use std::num::{NonZeroU32, NonZeroUsize};

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(
    after_help = "Built-in campaigns: kills, messages, restarts, soak, takeovers. `plausibility` prints how often and how \
fast the controller's checks of its inputs find a false sender, `radio` what becomes of frames that are lost, late \
and falsified (2,000 runs, or --sample N from --first M on), `signals` trips through corridors of signals, `cacc-mpc` \
against an ACC that stops for them (500 corridors, or --seeds N from --first M on)."
)]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    #[arg(conflicts_with = "merge")]
    pub campaign: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub sample: Option<NonZeroUsize>,
    /// Begin with run or corridor number N: `radio` and `signals` alone
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub first: Option<NonZeroUsize>,
    /// Runs of every combination, instead of what the file says
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub seeds: Option<NonZeroU32>,
    /// In parts.
    #[command(flatten)]
    pub parts: PartOptions,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
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
