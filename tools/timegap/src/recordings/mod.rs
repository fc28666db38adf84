//! Commands on recordings and layouts.

pub mod diff;
pub mod export;
pub mod info;
pub mod layouts;
pub mod recover;
pub mod replay;

use group::Error;
use recorder::{Recording, Tally};
use std::path::Path;

/// Opens the recording of a run's directory, or a file.
fn open(path: &Path) -> Result<Recording, Error> {
    Recording::open(path).map_err(|error| Error::Usage(error.to_string()))
}

/// What the recorder counted; counted anew where it did not live to say.
fn tally(recording: &Recording) -> Tally {
    recording.tally().cloned().unwrap_or_else(|| recording.count())
}

/// `n things`, or `1 thing`.
fn count(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}
