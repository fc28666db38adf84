//! Why a campaign is not done.

use super::file::{BUILTIN, RADIO};
use crate::plausibility;
use crate::signals;
use group::{Absent, Failure};
use scenario::faults::Kind;
use std::path::PathBuf;

/// Why a campaign is not done.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// Nothing says which.
    #[error(
        "no campaign is named, expected a file or one of {}, {RADIO}, {}, {}",
        BUILTIN.map(|builtin| builtin.name).join(", "),
        signals::NAME,
        plausibility::NAME
    )]
    NoneNamed,
    /// The runs have no numbers that their draws come from.
    #[error("--first is for the campaigns `{}` and `{}` alone", RADIO, signals::NAME)]
    FirstOfNone,
    /// The runs are not random drives.
    #[error("{option} is for the campaign `{}` alone", plausibility::NAME)]
    OfPlausibility {
        /// The option.
        option: &'static str,
    },
    /// A fault has nothing to act on.
    #[error("faults: {0}; this holds in every scenario of the campaign")]
    NothingToFault(Absent),
    /// Each run has its own seed.
    #[error(
        "--seeds is not for the campaign `{}`, whose run's number is its seed: expected --sample N from \
         --first M on",
        RADIO
    )]
    NoSeeds,
    /// An option of campaigns whose runs are kept.
    #[error("{option} is not for the campaign `{name}`, which always does all of its runs")]
    NotForAll {
        /// The option.
        option: &'static str,
        /// The campaign.
        name: &'static str,
    },
    /// The directory is another one's.
    #[error(
        "{} holds another campaign, or another shard of it, expected the one that it began with",
        directory.display()
    )]
    OtherBegun {
        /// The directory.
        directory: PathBuf,
    },
    /// In simulated time nothing is to be seen of a process fault.
    #[error(
        "a fault of kind `{kind}` acts on processes, expected mode = \"realtime\" in the campaign"
    )]
    FaultOfProcesses {
        /// Its kind.
        kind: Kind,
    },
    /// A journal has a run that is not of its part.
    #[error("{}: run {run} does not belong to this part of the campaign", path.display())]
    OtherPart {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
    /// A journal has a run that is known.
    #[error(
        "{}: run {run} is there twice, or in a directory before this one as well", path.display()
    )]
    Twice {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
}

impl Failure for CampaignError {}
