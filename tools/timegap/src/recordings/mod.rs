//! Commands on recordings and layouts.

mod capture;
pub mod diff;
pub mod export;
pub mod info;
pub mod layouts;
pub mod recover;
pub mod replay;

use group::Error;
use recorder::{Damage, Recording};
use std::path::Path;

/// Opens the recording of a run's directory, or a file.
fn open(path: &Path) -> Result<Recording, Error> {
    Ok(Recording::open(path)?)
}

/// Says on standard error what of a recording could not be read. The exit status of a command whose result is
/// not whole then is 1.
fn tell(recording: &Recording, damage: &[Damage]) {
    for damage in damage {
        eprintln!("{}: {damage}", recording.path().display());
    }
}

/// `n things`, or `1 thing`.
fn count(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}
