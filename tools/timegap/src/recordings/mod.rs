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
    for line in lines(damage, ToString::to_string) {
        eprintln!("{}: {line}", recording.path().display());
    }
}

/// Most damages that are told one by one.
const MOST_TOLD: usize = 20;

/// A line for each damage, and one for all beyond the first [`MOST_TOLD`].
fn lines(damage: &[Damage], line: impl Fn(&Damage) -> String) -> impl Iterator<Item = String> {
    let rest = damage.len().saturating_sub(MOST_TOLD);
    let rest =
        (rest > 0).then(|| format!("and {rest} more (`timegap info --verify --json` lists all)"));
    damage.iter().take(MOST_TOLD).map(line).collect::<Vec<_>>().into_iter().chain(rest)
}

/// `n things`, or `1 thing`.
fn count(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damages_beyond_the_first_are_one_line() {
        let damage = vec![Damage::CutOff { bytes: 1 }; 1_000];
        let told = |count: usize| lines(&damage[..count], |_| "one".into()).collect::<Vec<_>>();
        assert_eq!(told(MOST_TOLD).len(), MOST_TOLD);
        assert_eq!(told(1_000).len(), MOST_TOLD + 1);
        assert!(told(1_000)[MOST_TOLD].starts_with("and 980 more"), "{:?}", told(1_000));
    }
}
