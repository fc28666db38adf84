//! `timegap recording diff`: the first difference between two recordings.

use super::{open, print_damage};
use clap::Args;
use messages::{Place, Service, Topic};
use recorder::{Damage, Record, Recording};
use report::print;
use report::results::Document;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::process::ExitCode;
use supervise::{Error, UsageError};

#[derive(Debug, Args)]
pub struct DiffArguments {
    /// First results directory or recording
    pub a: PathBuf,
    /// Second results directory or recording
    pub b: PathBuf,
    /// Print the result as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &DiffArguments) -> Result<ExitCode, Error> {
    let (a, b) = (open(&arguments.a)?, open(&arguments.b)?);
    let comparison = compare(&a, &b);
    if comparison.messages == 0
        && let Some(damaged) = [&a, &b].into_iter().find(|file| !file.damage().is_empty())
    {
        let (place, why) = (damaged.path().display(), "damaged before its first message");
        return Err(UsageError::at(place, why, "a recording with messages").into());
    }
    print::show(arguments.json, &document(&comparison))?;
    Ok(if comparison.equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    equal: bool,
    messages: u64,
    /// Unreadable parts of the first and second recording, which were not compared.
    damage: [Vec<String>; 2],
    first: Option<Divergence>,
    diverging_streams: usize,
}

#[derive(Clone, Debug, Serialize)]
struct Divergence {
    topic: &'static str,
    source: String,
    /// Number of the message among its sender's on the topic, from 0.
    index: u64,
    publish_ns: i64,
    /// Dotted path of the field; `None` if one recording lacks the message.
    field: Option<String>,
    /// The field's value in the first recording; `None` if it lacks the message.
    a: Option<String>,
    b: Option<String>,
}

/// One sender's messages on one topic. Senders run in parallel: only the order of each sender's messages is
/// defined.
type Key = (Topic, u32);

#[derive(Default)]
struct Stream {
    counts: [u64; 2],
    /// Fingerprints of messages that one recording is ahead with, and its index.
    ahead: VecDeque<u64>,
    ahead_side: usize,
    diverges_at: Option<u64>,
}

impl Stream {
    fn add(&mut self, side: usize, bytes: &[u8]) {
        let index = self.counts[side];
        self.counts[side] += 1;
        if self.diverges_at.is_some() {
            return;
        }
        let print = xxhash_rust::xxh3::xxh3_64(bytes);
        if self.ahead.is_empty() || self.ahead_side == side {
            self.ahead_side = side;
            self.ahead.push_back(print);
        } else if self.ahead.pop_front() != Some(print) {
            self.diverges_at = Some(index);
            self.ahead = VecDeque::new();
        }
    }

    /// The first message that differs or that only one recording has.
    fn divergence(&self) -> Option<u64> {
        let [a, b] = self.counts;
        self.diverges_at.or((a != b).then_some(a.min(b)))
    }
}

fn compare(a: &Recording, b: &Recording) -> Comparison {
    let (streams, damage) = streams(a, b);
    for (recording, damage) in [a, b].into_iter().zip(&damage) {
        print_damage(recording, recording.damage());
        print_damage(recording, damage);
    }
    let told = |recording: &Recording, damage: &[Damage]| -> Vec<String> {
        recording.damage().iter().chain(damage).map(ToString::to_string).collect()
    };
    let damage = [told(a, &damage[0]), told(b, &damage[1])];
    let messages = streams.values().map(|stream| stream.counts[0].max(stream.counts[1])).sum();
    let diverging: BTreeMap<Key, u64> =
        streams.iter().filter_map(|(key, stream)| Some((*key, stream.divergence()?))).collect();
    // A second pass for these messages only.
    let [a, b] = [a, b].map(|recording| messages_at(recording, &diverging));
    let found = diverging
        .iter()
        .filter_map(|(key, index)| divergence(*key, *index, [a.get(key), b.get(key)]));
    let first = found.min_by_key(|divergence| divergence.publish_ns);
    Comparison {
        schema_version: 1,
        equal: first.is_none(),
        messages,
        damage,
        first,
        diverging_streams: diverging.len(),
    }
}

/// Reads both recordings in parallel by time; also returns the unreadable parts of each.
fn streams(a: &Recording, b: &Recording) -> (BTreeMap<Key, Stream>, [Vec<Damage>; 2]) {
    let mut streams: BTreeMap<Key, Stream> = BTreeMap::new();
    let mut sides = [a, b].map(Recording::records);
    let mut next = sides.each_mut().map(Iterator::next);
    loop {
        let side = match &next {
            [None, None] => break,
            [Some(_), None] => 0,
            [None, Some(_)] => 1,
            [Some(a), Some(b)] => usize::from(b.log_time_ns < a.log_time_ns),
        };
        let following = sides[side].next();
        let record = std::mem::replace(&mut next[side], following).expect("just seen");
        let stream = streams.entry((record.topic, record.header().source)).or_default();
        stream.add(side, record.bytes());
    }
    (streams, sides.map(|side| side.damage().to_vec()))
}

/// The message with the number `wanted` of each stream.
fn messages_at(recording: &Recording, wanted: &BTreeMap<Key, u64>) -> BTreeMap<Key, Record> {
    let mut found = BTreeMap::new();
    if wanted.is_empty() {
        return found;
    }
    let mut counts: BTreeMap<Key, u64> = BTreeMap::new();
    for record in recording.records() {
        let key = (record.topic, record.header().source);
        let count = counts.entry(key).or_default();
        if wanted.get(&key) == Some(count) {
            found.insert(key, record);
        }
        *count += 1;
    }
    found
}

/// The first of `places` whose bytes differ. The checksum differs with any other one, so that it comes last.
pub(super) fn first_difference<'a>(places: &'a [Place], a: &[u8], b: &[u8]) -> Option<&'a Place> {
    let differs = |place: &&Place| {
        let range = place.offset..place.offset + place.bytes;
        a[range.clone()] != b[range]
    };
    let is_checksum = |place: &&Place| place.path.starts_with("header.protection");
    let telling = places.iter().find(|place| !is_checksum(place) && differs(place));
    telling.or_else(|| places.iter().find(differs))
}

fn divergence(
    (topic, source): Key,
    index: u64,
    [a, b]: [Option<&Record>; 2],
) -> Option<Divergence> {
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
        if let Some(place) = first_difference(&places, a.bytes(), b.bytes()) {
            found.field = Some(place.path.clone());
            found.a = Some(place.read(a.bytes()).to_string());
            found.b = Some(place.read(b.bytes()).to_string());
        }
    }
    Some(found)
}

fn document(comparison: &Comparison) -> Document {
    let document = Document::new("diff", "Difference", comparison);
    let Some(first) = &comparison.first else {
        let of_what = match comparison.damage.iter().all(Vec::is_empty) {
            true => "",
            false => " in the readable parts",
        };
        let messages = comparison.messages;
        return document
            .verdict(true, format!("equal: {messages} messages{of_what}, byte for byte"));
    };
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "no message".into());
    let at = format!("{:.6} s", first.publish_ns as f64 / 1e9);
    let Divergence { topic, source, index, field, .. } = first;
    let mut facts = vec![
        ("message", format!("{index} of {topic} from {source}, at {at}")),
        ("first", value(&first.a)),
        ("second", value(&first.b)),
    ];
    facts.extend(field.clone().map(|field| ("field", field)));
    let streams = print::counted(comparison.diverging_streams as u64, "stream");
    let verdict = format!("different: {streams} of a sender and a topic, the first one at {at}");
    document.facts("First divergence", facts).verdict(false, verdict)
}
