//! Standard output, and the words that all results share.

pub use crate::duration::{carries, duration, p99};

use crate::results::{Document, width};
use std::io::{ErrorKind, Write as _};
use supervise::report::Outcome;
use supervise::{Error, RequirementVerdict};

/// Writes text on standard output. A closed pipe is not an error: its reader needs no more.
pub fn out(text: &str) -> Result<(), Error> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|reason| Error::Path {
            action: "write",
            path: "standard output".into(),
            reason,
        }),
    }
}

/// Prints a result without files of its own: as JSON, or as text.
pub fn show(json: bool, document: &Document) -> Result<(), Error> {
    out(&if json { document.json().to_owned() } else { document.console(width()) })
}

/// Writes a line on standard error. A closed one, as of a closed terminal, is not an error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

pub fn requirement(verdict: &RequirementVerdict) -> String {
    let word = if verdict.met { "met" } else { "BROKEN" };
    match verdict.margin {
        Some(margin) => {
            let margin = crate::chart::number(margin, 2);
            format!("{word}, margin {margin} {} at {:.2} s", verdict.unit, verdict.at_s)
        }
        None => format!("{word}, nothing in the drive decides it"),
    }
}

pub fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Collision => "COLLISION",
        Outcome::RedLight => "RED LIGHT",
        Outcome::SafeStop => "safe stop",
        Outcome::DrivenByBackup => "DRIVEN BY BACKUP",
        Outcome::RequirementBroken => "REQUIREMENT BROKEN",
        Outcome::NoStory => "NO STORY",
        Outcome::Aborted => "aborted",
    }
}

/// Ends of several runs: `completed`, or the number of each outcome.
///
/// ```
/// use supervise::report::Outcome::{Collision, Completed};
///
/// assert_eq!(report::print::outcomes([Completed, Collision, Completed]), "2 completed, 1 COLLISION");
/// assert_eq!(report::print::outcomes([Completed]), "completed");
/// ```
pub fn outcomes(runs: impl IntoIterator<Item = Outcome>) -> String {
    let mut kinds: Vec<(Outcome, usize)> = Vec::new();
    for run in runs {
        match kinds.iter_mut().find(|(outcome, _)| *outcome == run) {
            Some((_, count)) => *count += 1,
            None => kinds.push((run, 1)),
        }
    }
    if let [(outcome, 1)] = kinds.as_slice() {
        return outcome_word(*outcome).to_owned();
    }
    let words = kinds.iter().map(|(outcome, count)| format!("{count} {}", outcome_word(*outcome)));
    words.collect::<Vec<_>>().join(", ")
}
