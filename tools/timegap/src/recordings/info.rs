//! `timegap info`: what a recording holds.

use super::{count, open, tally};
use clap::Args;
use group::Error;
use messages::TOPICS;
use recorder::{Recording, Tally};
use report::print;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// A run's directory of results, or a recording
    pub run: PathBuf,
    /// Print it as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &InfoArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let tally = tally(&recording);
    if arguments.json {
        let text = serde_json::to_string_pretty(&as_json(&recording, &tally)).expect("plain data");
        print::out(&(text + "\n"))?;
    } else {
        print::out(&as_text(&recording, &tally))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Messages per second of a topic over the recording's length.
fn rate_hz(messages: u64, recording: &Recording) -> Option<f64> {
    let length_s = recording.end_ns() as f64 / 1e9;
    (length_s > 0.0).then(|| messages as f64 / length_s)
}

fn as_json(recording: &Recording, tally: &Tally) -> Value {
    let metadata = recording.metadata();
    let topics: serde_json::Map<_, _> = TOPICS
        .into_iter()
        .map(|topic| {
            let counts = tally.topics.get(topic.name()).copied().unwrap_or_default();
            let value = json!({
                "type": topic.layout().type_name,
                "bytes": topic.message_bytes(),
                "messages": counts.messages,
                "lost": counts.lost,
                "rate_hz": rate_hz(counts.messages, recording),
            });
            (topic.name().to_owned(), value)
        })
        .collect();
    json!({
        "schema_version": 1,
        "path": recording.path(),
        "bytes": recording.file_bytes(),
        "ended": recording.tally().is_some(),
        "damage": recording.damage().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "duration_s": recording.end_ns() as f64 / 1e9,
        "messages": tally.messages(),
        "lost": tally.lost(),
        "topics": topics,
        "incarnations": tally.incarnations,
        "scenario": metadata.scenario_name,
        "controller": metadata.controller,
        "mode": metadata.mode.name(),
        "seed": metadata.seed,
        "program": metadata.program,
        "programs": metadata.programs,
        "layout_version": metadata.layout_version,
        "started_unix_ns": metadata.started_unix_ns,
        "host": {
            "name": metadata.host.name,
            "kernel": metadata.host.kernel,
            "cpus": metadata.host.cpus,
        },
        "scheduling": metadata.scheduling,
    })
}

fn as_text(recording: &Recording, tally: &Tally) -> String {
    let metadata = recording.metadata();
    let mut text = format!(
        "{} · {} · {} · seed {}\n",
        metadata.scenario_name,
        metadata.controller,
        metadata.mode.name(),
        metadata.seed
    );
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<14} {value}").expect("a string takes all");
    };
    let started = jiff::Timestamp::from_nanosecond(metadata.started_unix_ns.into())
        .map_or_else(|_| "at a time unknown".into(), |time| time.strftime("%F %T UTC").to_string());
    let host = &metadata.host;
    line("recorded", format!("{started} by {}", metadata.program));
    line("on", format!("{}, Linux {}, {}", host.name, host.kernel, count(host.cpus as u64, "cpu")));
    for (service, granted) in &metadata.scheduling {
        let core = granted.core.map_or_else(|| "any core".into(), |core| format!("core {core}"));
        line(service, format!("{}, {core}", granted.granted));
    }
    for (service, program) in &metadata.programs {
        let (command, digest) = (&program.command, program.short_digest());
        line("program", format!("{service}: {command} (sha256 {digest}...)"));
    }
    for (service, processes) in &tally.incarnations {
        if *processes > 1 {
            line(service, format!("restarted {}", count(u64::from(processes - 1), "time")));
        }
    }
    let messages = tally.messages();
    let per_message = recording.file_bytes() as f64 / messages.max(1) as f64;
    line(
        "length",
        format!(
            "{:.2} s, {messages} messages, {} lost, {:.2} MiB ({per_message:.0} bytes a message)",
            recording.end_ns() as f64 / 1e9,
            tally.lost(),
            recording.file_bytes() as f64 / f64::from(1 << 20),
        ),
    );
    for damage in recording.damage() {
        line("INCOMPLETE", format!("{damage}: `timegap recover` makes it whole"));
    }
    writeln!(text, "\n  {:<22} {:>9} {:>8} {:>6}  type", "topic", "messages", "Hz", "lost")
        .expect("a string takes all");
    for topic in TOPICS {
        let counts = tally.topics.get(topic.name()).copied().unwrap_or_default();
        let rate = rate_hz(counts.messages, recording)
            .map_or_else(|| "-".into(), |rate| format!("{rate:.1}"));
        let (name, type_name) = (topic.name(), topic.layout().type_name);
        writeln!(
            text,
            "  {name:<22} {:>9} {rate:>8} {:>6}  {type_name}",
            counts.messages, counts.lost
        )
        .expect("a string takes all");
    }
    text
}
