//! Commands on recordings and layouts.

pub mod diff;
pub mod export;
pub mod info;
pub mod recover;
pub mod replay;
mod sheet;

use recorder::{Damage, Recording};
use runtime::Group;
use std::path::Path;
use supervise::{Error, UsageError, is_alive};

fn open(path: &Path) -> Result<Recording, Error> {
    Ok(Recording::open(path)?)
}

/// Refuses to write a result over the recording.
pub fn expect_another_file(recording: &Recording, out: &Path) -> Result<(), Error> {
    let same = std::fs::canonicalize(out)
        .and_then(|out| Ok(out == std::fs::canonicalize(recording.path())?))
        // A missing file is not the recording.
        .unwrap_or(false);
    let refusal =
        || UsageError::at(out.display(), "is the recording itself", "another file for the result");
    if same { Err(refusal().into()) } else { Ok(()) }
}

/// Reports unreadable parts of a recording on standard error. A command with an incomplete result then returns
/// status 1.
pub fn print_damage(recording: &Recording, damage: &[Damage]) {
    for line in lines(damage, in_words(recording, ToString::to_string)) {
        eprintln!("{}: {line}", recording.path().display());
    }
}

/// A damage in words. The open end of a recording in progress is expected; all else is in the words of `of_damage`.
fn in_words(
    recording: &Recording,
    of_damage: impl Fn(&Damage) -> String,
) -> impl Fn(&Damage) -> String {
    let goes_on = is_being_recorded(recording.path());
    move |damage| match damage {
        Damage::CutOff { .. } if goes_on => {
            "is still being recorded: later messages are missing".to_owned()
        }
        damage => of_damage(damage),
    }
}

/// True if the run of this recording is in progress.
fn is_being_recorded(path: &Path) -> bool {
    let live = std::fs::read_to_string(path.with_file_name("live.json")).unwrap_or_default();
    serde_json::from_str(&live).is_ok_and(|group: Group| is_alive(&group.root))
}

/// Most damages that are printed one by one.
const MOST_TOLD: usize = 20;

/// A line for each damage up to [`MOST_TOLD`], and one for the rest.
fn lines(damage: &[Damage], line: impl Fn(&Damage) -> String) -> impl Iterator<Item = String> {
    let rest = damage.len().saturating_sub(MOST_TOLD);
    let rest = (rest > 0)
        .then(|| format!("and {rest} more (`timegap recording info --verify --json` lists all)"));
    damage.iter().take(MOST_TOLD).map(line).collect::<Vec<_>>().into_iter().chain(rest)
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
