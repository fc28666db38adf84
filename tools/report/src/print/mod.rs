//! The console text after a run.

mod drive;
mod machine;
mod timing;

pub use crate::duration::{carries, duration, p99};
pub(crate) use drive::storyboard_remarks;
pub use drive::trip;

use crate::summary::Summary;
use drive::{drive, emergency_brake, radar, storyboard};
use group::report::{Outcome, ProgramReport};
use group::{Error, RecordingSummary, RequirementVerdict};
use machine::{faults, machine, messages};
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};
use timing::timing;

/// Writes text on standard output. A closed pipe is not an error: its reader needs no more.
///
/// # Errors
/// [`Error::Path`] if standard output cannot be written.
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

/// Writes a line on standard error. A closed one, as of a closed terminal, is not an error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// The run's outcome, figures and events, readable in ten seconds.
pub fn summary(summary: &Summary) -> String {
    let mut text = String::new();
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<14} {value}").expect("a string takes all");
    };
    line("outcome", outcome(summary));
    program(summary, &mut line);
    drive(summary, &mut line);
    emergency_brake(summary, &mut line);
    requirements(summary, &mut line);
    storyboard(summary, &mut line);
    radar(summary, &mut line);
    timing(summary, &mut line);
    let links = crate::link::lines(summary);
    for (label, text) in crate::radio::lines(summary).into_iter().chain(links) {
        line(label, text);
    }
    messages(summary, &mut line);
    faults(summary, &mut line);
    machine(summary, &mut line);
    if let Some(recording) = &summary.recording {
        line("recording", self::recording(recording));
    }
    format!(
        "{} · {} · {} · seed {}\n{text}",
        summary.scenario,
        summary.driver(),
        summary.mode,
        summary.seed
    )
}

/// The requirements of the scenario, with their margins.
fn requirements(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for (index, verdict) in summary.requirements.iter().enumerate() {
        let text = format!("{}: {}", verdict.requirement, requirement(verdict));
        line(if index == 0 { "requirements" } else { "" }, text);
    }
}

/// A requirement's verdict, in words.
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

/// The user's programs, and the performance of a foreign law's program.
fn program(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for service in &summary.services {
        let Some(program) = &service.program else { continue };
        let fared = match (&summary.timing.law_program, service.name) {
            (Some(report), "controller") => format!(", {}", fared(report)),
            _ => String::new(),
        };
        let (name, command) = (service.name, &program.command);
        line("program", format!("{name}: {command} (sha256 {}...){fared}", program.short_digest()));
    }
    for failure in summary.timing.law_program.iter().flat_map(|report| &report.failures) {
        line("", failure.clone());
    }
}

/// Performance of a foreign law's program, in a line.
pub fn fared(report: &ProgramReport) -> String {
    let mut parts = vec![format!("{} answers", report.answers)];
    for (count, what) in
        [(report.late, "late"), (report.refused, "refused"), (report.absent, "without a program")]
    {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    }
    if report.starts > 1 {
        parts.push(format!("started {} times", report.starts));
    }
    if report.given_up {
        parts.push("GIVEN UP: the backup law drove the rest".into());
    }
    parts.join(", ")
}

/// Outcome of a run, in a line.
pub fn outcome(summary: &Summary) -> String {
    let word = outcome_word(summary.outcome);
    let because = backup(summary)
        .or_else(|| summary.aborted_because.clone())
        .map_or_else(String::new, |why| format!(" ({why})"));
    let speed = match summary.simulated_per_wall {
        Some(ratio) if summary.mode == "lockstep" => format!(", {ratio:.0} simulated s per s"),
        _ => String::new(),
    };
    format!(
        "{word}{because}, {:.1} s driven in {:.2} s of wall time (ready after {:.0} ms{speed})",
        summary.duration_s, summary.wall_s, summary.ready_ms
    )
}

/// Driver of a run whose outcome is the backup's.
pub fn backup(summary: &Summary) -> Option<String> {
    let by_backup = summary.outcome == Outcome::DrivenByBackup;
    summary.law.as_ref().filter(|_| by_backup).map(ToString::to_string)
}

/// An outcome in a word.
pub fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Collision => "COLLISION",
        Outcome::RedLight => "RED LIGHT",
        Outcome::SafeStop => "safe stop",
        Outcome::DrivenByBackup => "DRIVEN BY BACKUP",
        Outcome::RequirementBroken => "REQUIREMENT BROKEN",
        Outcome::Aborted => "aborted",
    }
}

/// Ends of several runs: `completed`, or the number of each outcome.
///
/// ```
/// use group::report::Outcome::{Collision, Completed};
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

fn recording(recording: &RecordingSummary) -> String {
    let lost = match recording.lost {
        Some(0) => "0 lost".into(),
        Some(lost) if recording.failed.is_some() => format!("{lost} lost"),
        Some(lost) => format!("{lost} lost (the recorder read too late)"),
        None => "losses not counted".into(),
    };
    let failed =
        recording.failed.as_ref().map_or_else(String::new, |why| format!("; ENDS EARLY: {why}"));
    let mib = recording.bytes as f64 / f64::from(1 << 20);
    format!("{} messages, {lost}, {mib:.2} MiB{failed}", recording.messages)
}
