//! The arguments of `campaign`.

use clap::Args;
use group::{Failure, LawOptions};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::num::{NonZeroU32, NonZeroUsize};

/// Arguments of `campaign`.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[command(after_help = "`timegap list` describes the built-in campaigns.")]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: Option<String>,
    /// Content of the campaign as it takes effect: a part then needs no other file.
    #[arg(skip)]
    pub effective: Option<String>,
    /// Do only N of the runs, drawn by the first seed; `radio`: number of runs [default: 2000]
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Number of the first run (`radio`), corridor (`signals`) or scene (`curves`) [default: 1]
    #[arg(long, value_name = "N")]
    pub first: Option<NonZeroUsize>,
    /// Runs of every combination [default: as in the file]; `signals`: corridors [default: 500]; `curves`: roads, and
    /// queues of each kind [default: 1000]
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Hours of random drives without faults (`plausibility`) [default: 3]
    #[arg(long, value_name = "H")]
    pub hours: Option<Hours>,
    /// Judge every run by a requirement as well: a formula or a name (repeatable; docs/search.md)
    #[arg(long = "require", value_name = "FORMULA")]
    pub require: Vec<String>,
    /// Laws of the user's own. They drive if the campaign names no controllers. In `signals` they drive beside the two
    /// laws of the campaign. In `radio`, `plausibility` and `curves` one replaces its laws.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Seed of the random drives (`plausibility`) [default: 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u32>,
}

/// Hours of driving, from 0.01 to 1000.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
