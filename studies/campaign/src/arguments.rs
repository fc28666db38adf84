//! The arguments of `campaign`.

use clap::Args;
use frame::Options;
use frame::parts::PartOptions;
use group::{Failure, GroupOptions, LawOptions};
use report::results::ResultOptions;
use std::fmt;
use std::num::{NonZeroU32, NonZeroUsize};

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(
    mut_arg("laws", |laws| laws.conflicts_with("merge")),
    after_help = "`timegap list` describes the built-in campaigns."
)]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    #[arg(conflicts_with = "merge")]
    pub campaign: Option<String>,
    /// Do only N of the runs, drawn by the first seed; `radio`: number of runs [default: 2000]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub sample: Option<NonZeroUsize>,
    /// Number of the first run (`radio`), corridor (`signals`) or scene (`curves`) [default: 1]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub first: Option<NonZeroUsize>,
    /// Runs of every combination [default: as in the file]; `signals`: corridors [default: 500]; `curves`: roads, and
    /// queues of each kind [default: 1000]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub seeds: Option<NonZeroU32>,
    /// Hours of random drives without faults (`plausibility`) [default: 3]
    #[arg(long, value_name = "H", conflicts_with = "merge")]
    pub hours: Option<Hours>,
    /// Judge every run by a requirement as well: a formula or a name (repeatable; docs/search.md)
    #[arg(long = "require", value_name = "FORMULA", conflicts_with = "merge")]
    pub require: Vec<String>,
    /// Laws of the user's own. They drive if the campaign names no controllers. In `signals` they drive beside the two
    /// laws of the campaign. In `radio`, `plausibility` and `curves` one replaces its laws.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Seed of the random drives (`plausibility`) [default: 1]
    #[arg(long, value_name = "S", conflicts_with = "merge")]
    pub seed: Option<u32>,
    /// Parts of the campaign.
    #[command(flatten)]
    pub parts: PartOptions,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N", conflicts_with = "merge")]
    pub jobs: Option<NonZeroUsize>,
    /// Start of each run's processes.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}

/// Hours of driving, from 0.01 to 1000.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hours(f64);

/// Several laws where one drives.
#[derive(Debug, thiserror::Error)]
#[error("--law: {laws} laws, and the campaign `{campaign}` drives with one: expected one --law")]
pub struct SeveralLaws {
    campaign: &'static str,
    laws: usize,
}

impl Failure for SeveralLaws {}

impl CampaignArguments {
    /// The law of the user's own that drives `campaign`, or none.
    pub(crate) fn one_law(&self, campaign: &'static str) -> Result<&LawOptions, SeveralLaws> {
        match self.laws.laws.len() {
            0 | 1 => Ok(&self.laws),
            laws => Err(SeveralLaws { campaign, laws }),
        }
    }

    /// The options that all studies have.
    pub(crate) fn options(&self) -> Options<'_> {
        let Self { parts, jobs, group, results, .. } = self;
        Options { parts: Some(parts), jobs: *jobs, group, results }
    }
}

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

/// A text that is not such a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotHours;

impl fmt::Display for NotHours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected a number of hours from 0.01 to 1000")
    }
}

impl std::error::Error for NotHours {}
