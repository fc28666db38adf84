//! The arguments of `campaign`.

use clap::Args;
use frame::parts::PartOptions;
use group::GroupOptions;
use report::results::ResultOptions;
use std::fmt;
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
    /// Hours of random drives without faults: `plausibility` alone [default: 3]
    #[arg(long, value_name = "H", conflicts_with = "merge")]
    pub hours: Option<Hours>,
    /// Seed of these drives: `plausibility` alone [default: 1]
    #[arg(long, value_name = "S", conflicts_with = "merge")]
    pub seed: Option<u32>,
    /// In parts.
    #[command(flatten)]
    pub parts: PartOptions,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub jobs: Option<NonZeroUsize>,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which forms.
    #[command(flatten)]
    pub results: ResultOptions,
}

/// A number of hours that a study can drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hours(f64);

impl From<Hours> for f64 {
    fn from(hours: Hours) -> Self {
        hours.0
    }
}

impl std::str::FromStr for Hours {
    type Err = NotHours;

    fn from_str(text: &str) -> Result<Self, NotHours> {
        let hours = text.parse().ok().filter(|hours| (0.01..=1_000.0).contains(hours));
        hours.map(Self).ok_or(NotHours)
    }
}

/// A text is no number of hours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotHours;

impl fmt::Display for NotHours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected a number of hours from 0.01 to 1000")
    }
}

impl std::error::Error for NotHours {}
