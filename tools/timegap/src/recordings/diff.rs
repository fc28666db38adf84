//! `timegap diff`: where two recordings part.

use super::open;
use clap::Args;
use group::Error;
use messages::Service;
use messages::Topic;
use recorder::{Record, Recording};
use report::print;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// A run's directory of results, or a recording
    pub a: PathBuf,
    /// Another
    pub b: PathBuf,
    /// Print the result as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &DiffArguments) -> Result<ExitCode, Error> {
    let [a, b] = [&arguments.a, &arguments.b].map(|path| open(path));
    let comparison = compare(&a?, &b?);
    if arguments.json {
        print::out(&(serde_json::to_string_pretty(&comparison).expect("plain data") + "\n"))?;
    } else {
        print::out(&as_text(&comparison))?;
    }
    Ok(if comparison.equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What a comparison found.
#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    equal: bool,
    /// Messages compared.
    messages: usize,
    /// The first divergence in time.
    first: Option<Divergence>,
    /// How many senders' messages on a topic diverge.
    diverging_streams: usize,
}

/// Where one sender's messages on one topic part.
#[derive(Clone, Debug, Serialize)]
struct Divergence {
    topic: &'static str,
    source: String,
    /// Which of the sender's messages on the topic, counted from 0.
    index: usize,
    /// When the message was published, ns of run time.
    publish_ns: i64,
    /// The field, by its dotted path; none if one recording has no such message.
    field: Option<String>,
    /// The field's value in the first recording; none if it has no such message.
    a: Option<String>,
    /// The same in the second.
    b: Option<String>,
}

/// The messages of each sender on each topic. Senders run beside each other: only the order of each
/// one's own messages means something.
fn streams(recording: &Recording) -> BTreeMap<(Topic, u32), Vec<Record<'_>>> {
    let mut streams: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for record in recording.records() {
        streams.entry((record.topic, record.header().source)).or_default().push(record);
    }
    streams
}

fn compare(a: &Recording, b: &Recording) -> Comparison {
    let [a, b] = [a, b].map(streams);
    let keys: std::collections::BTreeSet<_> = a.keys().chain(b.keys()).copied().collect();
    let mut divergences = Vec::new();
    let mut messages = 0;
    for key in keys {
        let [a, b] = [&a, &b].map(|streams| streams.get(&key).map_or(&[][..], Vec::as_slice));
        messages += a.len().max(b.len());
        divergences.extend(divergence(key, a, b));
    }
    let first = divergences.iter().min_by_key(|d| d.publish_ns).cloned();
    Comparison {
        schema_version: 1,
        equal: first.is_none(),
        messages,
        first,
        diverging_streams: divergences.len(),
    }
}

fn divergence(
    (topic, source): (Topic, u32),
    a: &[Record<'_>],
    b: &[Record<'_>],
) -> Option<Divergence> {
    let common = a.iter().zip(b).position(|(a, b)| a.bytes != b.bytes);
    let index = match common {
        Some(index) => index,
        None if a.len() == b.len() => return None,
        None => a.len().min(b.len()),
    };
    let [a, b] = [a.get(index), b.get(index)];
    let publish_ns = [a, b].into_iter().flatten().map(|record| record.publish_time_ns).min()?;
    let source = Service::ALL.into_iter().find(|service| service.to_wire() == source);
    let mut found = Divergence {
        topic: topic.name(),
        source: source.map_or_else(|| "an unknown sender".into(), |source| source.to_string()),
        index,
        publish_ns,
        field: None,
        a: a.map(|_| "a message".into()),
        b: b.map(|_| "a message".into()),
    };
    if let (Some(a), Some(b)) = (a, b) {
        let places = topic.layout().scalars();
        let differs = |place: &&messages::Place| {
            let range = place.offset..place.offset + place.bytes;
            a.bytes[range.clone()] != b.bytes[range]
        };
        // The checksum differs whenever something else does.
        let told = |place: &&messages::Place| !place.path.starts_with("header.protection");
        let place = places.iter().filter(differs).find(told);
        if let Some(place) = place.or_else(|| places.iter().find(differs)) {
            found.field = Some(place.path.clone());
            found.a = Some(place.read(a.bytes).to_string());
            found.b = Some(place.read(b.bytes).to_string());
        }
    }
    Some(found)
}

fn as_text(comparison: &Comparison) -> String {
    let Some(first) = &comparison.first else {
        return format!("equal: {} messages, byte for byte\n", comparison.messages);
    };
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "no message".into());
    let field = first.field.as_ref().map_or_else(String::new, |field| format!(", {field}"));
    let others = match comparison.diverging_streams - 1 {
        0 => String::new(),
        n => format!(
            "  {} on other topics or from other senders diverge later\n",
            super::count(n as u64, "stream")
        ),
    };
    format!(
        "first divergence: {} from {}, message {}, at {:.6} s{field}\n  first          {}\n  \
         second         {}\n{others}",
        first.topic,
        first.source,
        first.index,
        first.publish_ns as f64 / 1e9,
        value(&first.a),
        value(&first.b),
    )
}
