//! The messages of a file, one after another in the order of their log times, in bounded memory.
//!
//! A file of ours is in that order, and one chunk at a time is in memory. Files of other writers
//! need not be. Their parts in order ([`Segment`]) are merged, with one chunk of each part that
//! overlaps.

use crate::cdr::ENCAPSULATION;
use crate::definitions::Definitions;
use crate::outline::Segment;
use crate::source::{Source, Spot, Window};
use crate::{Damage, Record};
use bags::mcap::{self as format, HEAD, Malformed, opcode};
use bags::mcap::{LONGEST_CHUNK, UnpackError, unpack};
use messages::Topic;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// Bytes of messages outside chunks that are taken at once.
const RUN_BYTES: usize = 1 << 20;
/// Most bytes of the file that are in memory to be merged.
const MOST_MERGED: usize = 96 << 20;

/// The messages of a recording, in the order of their log times.
#[derive(Debug)]
pub struct Records {
    source: Source,
    epoch_ns: i64,
    topics: Vec<Topic>,
    definitions: Definitions,
    /// Parts of the file that were not begun, earliest first.
    waiting: VecDeque<Segment>,
    /// The part with the next message on top.
    open: BinaryHeap<Part>,
    /// Parts that were begun so far.
    begun: u64,
    /// Bytes of the file that the open parts hold.
    held: usize,
    damage: Vec<Damage>,
}

/// Reason why a part of the file gives no messages.
#[derive(Debug, thiserror::Error)]
enum BrokenPart {
    #[error("it is longer than a chunk may be")]
    TooLong,
    #[error("its lengths do not fit")]
    Lengths,
    #[error("a record in it is not whole")]
    Record,
    #[error("a message in it is not whole")]
    Message,
    #[error(transparent)]
    Unpack(#[from] UnpackError),
    #[error(transparent)]
    File(#[from] io::Error),
}

/// A part of the file that is being read.
#[derive(Debug)]
struct Part {
    number: u64,
    window: Window,
    at: u64,
    to: u64,
    bytes: Arc<Vec<u8>>,
    entries: VecDeque<Entry>,
}

/// A message in a part's bytes.
#[derive(Clone, Debug)]
struct Entry {
    topic: Topic,
    log_time: u64,
    publish_time: u64,
    range: Range<usize>,
}

impl Records {
    pub(crate) fn new(
        source: &Source,
        epoch_ns: i64,
        definitions: &Definitions,
        segments: &[Segment],
        topics: &[Topic],
    ) -> Self {
        let mut waiting: VecDeque<_> = segments.iter().copied().collect();
        waiting.make_contiguous().sort_by_key(|segment| segment.first);
        Self {
            source: source.clone(),
            epoch_ns,
            topics: topics.to_vec(),
            definitions: definitions.clone(),
            waiting,
            open: BinaryHeap::new(),
            begun: 0,
            held: 0,
            damage: Vec::new(),
        }
    }

    /// Damage up to here.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        &self.damage
    }

    /// The definitions that were met up to here.
    pub(crate) fn into_definitions(self) -> Definitions {
        self.definitions
    }

    /// Opens the parts of the file whose messages may be next.
    fn open_parts(&mut self) {
        loop {
            let now = self.open.peek().and_then(Part::log_time);
            let is_due = |segment: &Segment| now.is_none_or(|now| segment.first <= now);
            let Some(segment) = self.waiting.front().copied().filter(is_due) else { return };
            self.waiting.pop_front();
            if self.held > MOST_MERGED {
                self.leave_out(segment);
                continue;
            }
            self.begun += 1;
            let part = Part {
                number: self.begun,
                window: Window::new(&self.source),
                at: segment.from,
                to: segment.to,
                bytes: Arc::default(),
                entries: VecDeque::new(),
            };
            self.go_on(part);
        }
    }

    /// Reads on in `part`, and keeps it open if it has messages.
    fn go_on(&mut self, mut part: Part) {
        self.fill(&mut part);
        if part.at >= part.to {
            part.window = Window::new(&self.source);
        }
        if !part.entries.is_empty() {
            self.held += part.held();
            self.open.push(part);
        }
    }

    fn leave_out(&mut self, segment: Segment) {
        let left_out = segment.to - segment.from;
        for damage in &mut self.damage {
            if let Damage::Disorder { bytes } = damage {
                *bytes += left_out;
                return;
            }
        }
        self.damage.push(Damage::Disorder { bytes: left_out });
    }

    /// Reads on in `part` until it has messages or is at its end.
    fn fill(&mut self, part: &mut Part) {
        while part.entries.is_empty() && part.at < part.to {
            let spot = match part.window.spot(part.at) {
                Ok(Some(spot)) => spot,
                Ok(None) => return part.at = part.to,
                // The file is shorter than when it was opened.
                Err(error) => {
                    let (offset, bytes) = (part.at, part.to - part.at);
                    let reason = error.to_string();
                    self.damage.push(Damage::Chunk { offset, bytes, reason });
                    return part.at = part.to;
                }
            };
            let read = match spot.opcode {
                opcode::CHUNK => self.chunk(part, spot),
                opcode::MESSAGE => self.run_of_messages(part, spot),
                _ => Ok(spot.end()),
            };
            part.at = read.unwrap_or_else(|reason| {
                let (offset, bytes) = (spot.at, HEAD as u64 + spot.length);
                let reason = reason.to_string();
                self.damage.push(Damage::Chunk { offset, bytes, reason });
                spot.end()
            });
        }
    }

    /// Takes a chunk apart; returns where the next record begins.
    fn chunk(&mut self, part: &mut Part, spot: Spot) -> Result<u64, BrokenPart> {
        let length = usize::try_from(spot.length).ok().filter(|_| spot.length <= LONGEST_CHUNK);
        let length = length.ok_or(BrokenPart::TooLong)?;
        let body = part.window.bytes(spot.body(), length)?;
        let chunk = format::chunk(body).map_err(|_| BrokenPart::Lengths)?;
        let records = unpack(&chunk)?;
        let whole = self.records(&records, &mut part.entries);
        part.bytes = Arc::new(records);
        whole.map_err(|_| BrokenPart::Record)?;
        Ok(spot.end())
    }

    /// Takes the messages outside chunks from `first` on.
    fn run_of_messages(&mut self, part: &mut Part, first: Spot) -> Result<u64, BrokenPart> {
        let mut bytes = Vec::new();
        let mut spot = first;
        loop {
            let length = usize::try_from(spot.length).ok().filter(|length| *length <= RUN_BYTES);
            if let Some(length) = length {
                let read = part.window.bytes(spot.at, HEAD + length);
                bytes.extend_from_slice(read?);
            }
            let end = spot.end();
            let next = if end < part.to { part.window.spot(end) } else { Ok(None) };
            match next {
                Ok(Some(next)) if next.opcode == opcode::MESSAGE && bytes.len() < RUN_BYTES => {
                    spot = next;
                }
                _ => break,
            }
        }
        let whole = self.records(&bytes, &mut part.entries);
        part.bytes = Arc::new(bytes);
        whole.map_err(|_| BrokenPart::Message)?;
        Ok(spot.end())
    }

    /// Takes the records in `bytes`: definitions, and messages into `entries`.
    fn records(&mut self, bytes: &[u8], entries: &mut VecDeque<Entry>) -> Result<(), Malformed> {
        let mut at = 0;
        let mut ordered = true;
        let mut result = Ok(());
        while at < bytes.len() {
            let Some((opcode, body)) = record(&bytes[at..]) else {
                result = Err(Malformed);
                break;
            };
            let begin = at + HEAD;
            at = begin + body.len();
            match opcode {
                opcode::SCHEMA => self.definitions.schema(&format::schema(body)?),
                opcode::CHANNEL => {
                    let known = self.definitions.other_layout().is_some();
                    self.definitions.channel(&format::channel(body)?);
                    if let Some(topic) = self.definitions.other_layout().filter(|_| !known) {
                        self.damage.push(Damage::Layout { topic: topic.to_owned() });
                    }
                }
                opcode::MESSAGE => {
                    let (head, payload) = format::message(body)?;
                    let Some(topic) = self.definitions.topic(head.channel) else { continue };
                    if !self.topics.contains(&topic) {
                        continue;
                    }
                    if !is_ours(topic, payload) {
                        self.count_unreadable(topic);
                        continue;
                    }
                    let start = at - topic.message_bytes();
                    let (log_time, publish_time) = (head.log_time, head.publish_time);
                    ordered &= entries.back().is_none_or(|last| last.log_time <= log_time);
                    entries.push_back(Entry { topic, log_time, publish_time, range: start..at });
                }
                _ => {}
            }
        }
        if !ordered {
            // Stable: messages of one instant keep the file's order.
            entries.make_contiguous().sort_by_key(|entry| entry.log_time);
        }
        result
    }

    fn count_unreadable(&mut self, topic: Topic) {
        for damage in &mut self.damage {
            if let Damage::Payload { topic: known, messages } = damage
                && *known == topic
            {
                *messages += 1;
                return;
            }
        }
        self.damage.push(Damage::Payload { topic, messages: 1 });
    }
}

impl Part {
    fn log_time(&self) -> Option<u64> {
        self.entries.front().map(|entry| entry.log_time)
    }

    fn held(&self) -> usize {
        self.bytes.len() + self.window.held() + self.entries.capacity() * size_of::<Entry>()
    }
}

/// Greater is earlier; of messages of one instant, that of the part which was begun earlier.
impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        (other.log_time(), other.number).cmp(&(self.log_time(), self.number))
    }
}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl Iterator for Records {
    type Item = Record;

    fn next(&mut self) -> Option<Record> {
        if !self.waiting.is_empty() || self.open.is_empty() {
            self.open_parts();
        }
        let mut part = self.open.pop()?;
        let entry = part.entries.pop_front().expect("an open part has messages");
        let bytes = Arc::clone(&part.bytes);
        if part.entries.is_empty() {
            self.held -= part.held();
            part.bytes = Arc::default();
            self.go_on(part);
        } else {
            self.open.push(part);
        }
        Some(Record {
            topic: entry.topic,
            log_time_ns: run_time(entry.log_time, self.epoch_ns),
            publish_time_ns: run_time(entry.publish_time, self.epoch_ns),
            chunk: bytes,
            range: entry.range,
        })
    }
}

/// Opcode and body of the record at the start of `bytes`, if all of it is there.
fn record(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (opcode, length) = format::head(bytes).ok()?;
    let length = usize::try_from(length).ok()?;
    Some((opcode, bytes[HEAD..].get(..length)?))
}

/// True if `payload` is a message of `topic` as we lay it out.
fn is_ours(topic: Topic, payload: &[u8]) -> bool {
    let body = payload.strip_prefix(&ENCAPSULATION);
    body.is_some_and(|body| body.len() == topic.message_bytes())
}

/// A file's time as run time, ns.
fn run_time(ns: u64, epoch_ns: i64) -> i64 {
    i64::try_from(i128::from(ns) - i128::from(epoch_ns)).unwrap_or(i64::MAX)
}
