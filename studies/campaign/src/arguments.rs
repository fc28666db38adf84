//! The arguments of `campaign`.

use clap::Args;
use frame::DriveOptions;
use serde::{Deserialize, Serialize};
use std::num::{NonZeroU32, NonZeroUsize};

/// Arguments of `campaign`.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[command(after_help = "`timegap list` describes the built-in campaigns.")]
pub struct CampaignArguments {
    /// A campaign file, an OpenSCENARIO parameter variation (.xosc), or the name of a built-in campaign
    pub campaign: String,
    /// Content of the campaign as it takes effect: a part then needs no other file.
    #[arg(skip)]
    pub effective: Option<String>,
    /// Do only N of the runs, drawn by the first seed
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// The first seed [default: as in the file]
    #[arg(long, value_name = "N")]
    pub first: Option<u32>,
    /// Runs of every combination, each with a seed of its own [default: as in the file]
    #[arg(long, value_name = "N")]
    pub seeds: Option<NonZeroU32>,
    /// Laws that drive in place of the file's, and keys and requirements of all runs.
    #[command(flatten)]
    pub drives: DriveOptions,
}
