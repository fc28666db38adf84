//! A population: random drives by their numbers, and a judge.

use crate::figures::{Figure, Group};
use frame::batch::Done;
use scenario::Scenario;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;
use supervise::{Error, UsageError};

pub use crate::figures::{Drive, Planned};
pub use frame::DriveOptions;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Finding {
    /// No drive may have it.
    Breaks(String),
    /// A limit of a figure decides how many drives may have it.
    Counts(String),
}

/// Random drives by their numbers, and a judge.
pub trait Population: Sized + Sync {
    /// Facts of a drive, by its ground truth.
    type Facts: Serialize + DeserializeOwned + Clone + Send + 'static;

    /// Name, as given on the command line.
    const NAME: &'static str;
    const TITLE: &'static str;
    /// Scenes where nothing else is asked for.
    const NUMBERS: usize;
    /// Names of the keys that a drive has beside its number and law.
    const KEYS: &'static [&'static str];

    /// A limit that is exceeded breaks the verdict.
    const LIMITS_DECIDE: bool = true;

    /// The population with the laws that the user names; without any with its own.
    fn new(laws: Vec<String>) -> Result<Self, Error>;

    /// Law and keys of each drive of a number.
    fn drives(&self, number: usize) -> Vec<(String, Vec<String>)>;

    /// All drives of these numbers.
    fn plan(&self, numbers: Range<usize>) -> Vec<Planned> {
        let of_number = |number| {
            let drives = self.drives(number).into_iter();
            drives.map(move |(law, keys)| Planned { number, law, keys })
        };
        numbers.flat_map(of_number).collect()
    }

    fn scenario(&self, planned: &Planned, options: &DriveOptions) -> Result<Scenario, Error>;

    fn judge(&self, planned: &Planned, scenario: &Scenario, done: &Done) -> Self::Facts;

    /// True if the drive counts in the figures with limits.
    fn counts(_: &Drive<Self::Facts>) -> bool {
        true
    }

    /// True if the drive may have no finding. Others are there for comparison.
    fn is_judged(_: &Drive<Self::Facts>) -> bool {
        true
    }

    /// The finding about a drive, if there is one.
    fn finding(_: &Drive<Self::Facts>) -> Option<Finding> {
        None
    }

    /// Figures over the counted drives.
    fn figures() -> Vec<Figure<Self::Facts>>;

    /// Tables of the drives with something in common.
    fn groups() -> Vec<Group<Self::Facts>>;
}

/// The only law that drives, or the population's own.
pub fn only_law(laws: Vec<String>, own: &str, population: &'static str) -> Result<String, Error> {
    match laws.as_slice() {
        [] => Ok(own.to_owned()),
        [law] => Ok(law.clone()),
        laws => {
            let why = format_args!("one law drives `{population}`");
            Err(UsageError::option("--controllers", laws.join(","), why, "one of them").into())
        }
    }
}
