//! Standard output, and the words that all results share.

pub use crate::results::duration;
use crate::results::{Document, width};
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use messages::Service;
use runtime::statistics::Percentiles;
use scenario::faults::Helper;
use std::io::{ErrorKind, Write as _};
use supervise::report::Outcome;
use supervise::{Error, FaultRecord, RequirementVerdict};

/// Writes text on standard output. A closed pipe is not an error: its reader needs no more.
pub fn out(text: &str) -> Result<(), Error> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(Error::path("write", "standard output".as_ref())),
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

/// A number of things: "1 run", "2 runs".
pub fn counted(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
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

/// True if `count` samples carry the percentile of `share`: one of them at least is expected beyond it.
///
/// ```
/// use report::print::carries;
///
/// assert!(carries(100, 0.99) && !carries(99, 0.99));
/// ```
pub fn carries(count: u64, share: f64) -> bool {
    // Rounded: 100 * (1 - 0.99) is a little more than 1 in binary.
    (count as f64 * (1.0 - share) * 1e6).round() >= 1e6
}

/// The 99th percentile where the samples carry it, in µs.
pub fn p99(p: &Percentiles) -> Option<f64> {
    carries(p.count, 0.99).then_some(p.p99)
}

/// A bar over a number of runs.
pub fn count_bar(runs: usize, quiet: bool) -> ProgressBar {
    bar(runs as u64, "{msg} {wide_bar} {pos}/{len}, {left} to go", quiet)
}

/// A bar on a terminal; hidden elsewhere.
pub fn bar(length: u64, template: &str, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("the template is valid").with_key(
        "left",
        |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            // The remaining time is unknown until the first run has ended.
            let written = match state.pos() {
                0 => text.write_str("–"),
                _ => write!(text, "{:#}", HumanDuration(state.eta())),
            };
            written.expect("a line takes all");
        },
    );
    ProgressBar::new(length).with_style(style)
}

/// Kind and target of a fault: `kill controller`.
pub fn fault_name(record: &FaultRecord) -> String {
    let target = record.service.map(Service::name).or(record.topic);
    let target = target.or(record.helper.map(Helper::name)).unwrap_or_default();
    format!("{} {target}", record.kind).trim_end().to_owned()
}

/// Effect and end of a fault, as far as they are known: `detected after 1.20 ms, back after 9.80 ms by restart`.
pub fn fault_outcome(record: &FaultRecord) -> String {
    let after = |us: Option<f64>, what: &str| us.map(|us| format!("{what} after {}", duration(us)));
    let by = record.recovered_by.map_or_else(String::new, |by| format!(" by {}", by.name()));
    let parts = [
        after(record.detected_after_us, "detected"),
        after(record.recovered_after_us, "back").map(|back| back + &by),
        record.messages.map(|messages| format!("{messages} messages")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_choose_their_unit() {
        assert_eq!(duration(12.34), "12.3 µs");
        assert_eq!(duration(1234.0), "1.23 ms");
        assert_eq!(duration(2_500_000.0), "2.50 s");
    }
}
