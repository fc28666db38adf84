//! `timegap recording info`: the contents of a recording.

use super::{in_words, lines, open};
use clap::Args;
use messages::TOPICS;
use recorder::{Damage, Recording, Survey};
use report::print;
use report::results::{self, Column, Document, Fact, Table, number, word};
use runtime::Mode;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use supervise::Error;

#[derive(Debug, Args)]
pub struct InfoArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// Read every message and check every chunk, not only the file's statistics
    #[arg(long)]
    pub verify: bool,
    /// Print the contents as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &InfoArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let statistics = if arguments.verify { None } else { recording.statistics() };
    let survey = statistics.unwrap_or_else(|| recording.survey());
    print::show(arguments.json, &document(&recording, &survey))?;
    Ok(ExitCode::SUCCESS)
}

/// Messages per second of a topic over the recording's length.
fn rate_hz(messages: u64, survey: &Survey) -> Option<f64> {
    let length_s = survey.end_ns as f64 / 1e9;
    (length_s > 0.0).then(|| messages as f64 / length_s)
}

fn as_json(recording: &Recording, survey: &Survey) -> Value {
    let (metadata, tally) = (recording.metadata(), &survey.tally);
    let topics: serde_json::Map<_, _> = TOPICS
        .into_iter()
        .map(|topic| {
            let counts = tally.topics.get(topic.name()).copied().unwrap_or_default();
            let value = json!({
                "type": topic.layout().type_name,
                "bytes": topic.message_bytes(),
                "messages": counts.messages,
                "lost": counts.lost,
                "rate_hz": rate_hz(counts.messages, survey),
            });
            (topic.name().to_owned(), value)
        })
        .collect();
    json!({
        "schema_version": 1,
        "path": recording.path().to_string_lossy(),
        "bytes": recording.file_bytes(),
        "ended": recording.tally().is_some(),
        "damage": survey.damage.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "duration_s": survey.end_ns as f64 / 1e9,
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
        "host": metadata.host.as_ref().map(|host| {
            json!({ "name": host.name, "kernel": host.kernel, "cpus": host.cpus })
        }),
        "law": metadata.law,
        "scheduling": metadata.scheduling,
    })
}

fn document(recording: &Recording, survey: &Survey) -> Document {
    let (metadata, tally) = (recording.metadata(), &survey.tally);
    let mut facts: Vec<Fact> = Vec::new();
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
    let at = jiff::Timestamp::from_nanosecond(metadata.started_unix_ns.into()).map_or_else(
        |_| "at an unknown time".into(),
        |time| time.strftime("%F %T UTC").to_string(),
    );
    let started = if metadata.mode == Mode::Lockstep { "in simulated time".into() } else { at };
    add("recorded", format!("{started} by {}", metadata.program));
    if let Some(host) = &metadata.host {
        let cpus = print::counted(host.cpus as u64, "cpu");
        add("on", format!("{}, Linux {}, {cpus}", host.name, host.kernel));
    }
    for (service, granted) in &metadata.scheduling {
        let core = granted.core.map_or_else(|| "any core".into(), |core| format!("core {core}"));
        add(service, format!("{}, {core}", granted.granted));
    }
    for (service, program) in &metadata.programs {
        let (command, digest) = (&program.command, program.short_digest());
        add("program", format!("{service}: {command} (sha256 {digest}...)"));
    }
    for (service, processes) in &tally.incarnations {
        if *processes > 1 {
            add(service, format!("restarted {}", print::counted(u64::from(processes - 1), "time")));
        }
    }
    let messages = tally.messages();
    let per_message = recording.file_bytes() as f64 / messages.max(1) as f64;
    add(
        "length",
        format!(
            "{:.2} s, {messages} messages, {} lost, {:.2} MiB ({per_message:.0} bytes a message)",
            survey.end_ns as f64 / 1e9,
            tally.lost(),
            recording.file_bytes() as f64 / f64::from(1 << 20),
        ),
    );
    let advised = |damage: &Damage| format!("{damage}: `timegap recording recover` repairs it");
    for damage in lines(&survey.damage, in_words(recording, advised)) {
        add("INCOMPLETE", damage);
    }
    let whole = as_json(recording, survey);
    let rows: Vec<Value> = (TOPICS.into_iter())
        .map(|topic| {
            let mut row = whole["topics"][topic.name()].clone();
            row["topic"] = json!(topic.name());
            row
        })
        .collect();
    let columns: [Column<Value>; 5] = [
        word("topic", "topic", "Topic"),
        results::count("messages", "messages", "Recorded messages"),
        number("rate_hz", "Hz", "", 1, "Messages a second"),
        results::count("lost", "lost", "Messages that the recorder missed"),
        word("type", "type", "Type of the messages"),
    ];
    let (scenario, law) = (&metadata.scenario_name, &metadata.controller);
    let (mode, seed) = (metadata.mode.name(), metadata.seed);
    Document::new("info", "Recording", &whole)
        .about(format!("{scenario} · {law} · {mode} · seed {seed}"))
        .facts("Recording", facts)
        .table(Table::new("Topics", &columns, &rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use recorder::{LawNames, Metadata, Tally, Writer};
    use scenario::{Overrides, Scenario};
    use std::io::Cursor;

    #[test]
    fn text_of_a_file_does_not_reach_the_terminal_as_control_characters() {
        let scenario = Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default()))
            .expect("built in");
        let scheduling = serde_json::json!({
            "requested": "", "granted": "\u{1b}[2J", "core": null, "memory_locked": false, "refused": []
        });
        let granted = serde_json::from_value(scheduling).expect("a grant");
        let services = [("\u{1b}]0;title\u{7}".to_owned(), granted)].into();
        let of_run = Metadata::new(&scenario, Mode::Realtime, 0, services, LawNames::default());
        let metadata = Metadata {
            scenario_name: "\u{1b}[31mred\nanother line".into(),
            program: "\u{9b}31m".into(),
            ..of_run
        };
        let mut file = Cursor::new(Vec::new());
        let writer = Writer::begin(&mut file, &metadata).expect("memory");
        writer.finish(&Tally::default()).expect("memory");
        let recording = Recording::of_bytes("x.mcap".into(), file.get_ref()).expect("a recording");
        let text = document(&recording, &recording.survey()).console(80);
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
        assert!(text.starts_with("\u{fffd}[31mred\nanother line"), "{text:?}");
    }
}
