//! The messages of a file, one after another in the order of their log times. One chunk at a time is in memory.

use crate::Damage;
use crate::cdr::ENCAPSULATION;
use crate::definitions::Definitions;
use crate::source::{Source, Spot, Window};
use bags::mcap::{self as format, LONGEST_CHUNK, Malformed, UnpackError, opcode, unpack};
use messages::{Header, Message, Topic};
use std::collections::VecDeque;
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// One recorded message. It keeps its chunk of the file in memory: copy what must live long.
#[derive(Clone, Debug)]
pub struct Record {
    pub topic: Topic,
    /// Time of its publication by its sender's clock, ns of run time. The file is in this order.
    pub log_time_ns: i64,
    /// Time of publication by its sender, ns of run time.
    pub publish_time_ns: i64,
    chunk: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl Record {
    /// The bytes of the topic's struct.
    pub fn bytes(&self) -> &[u8] {
        &self.chunk[self.range.clone()]
    }

    /// The header that every message starts with.
    pub fn header(&self) -> Header {
        bytemuck::pod_read_unaligned(&self.bytes()[..size_of::<Header>()])
    }

    /// The message, if `T` is the topic's type.
    pub fn message<T: Message>(&self) -> Option<T> {
        (self.topic == T::TOPIC).then(|| bytemuck::pod_read_unaligned(self.bytes()))
    }
}

impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        let times = |record: &Self| (record.topic, record.log_time_ns, record.publish_time_ns);
        times(self) == times(other) && self.bytes() == other.bytes()
    }
}

/// A message with the time under which it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed<T> {
    pub log_time_ns: i64,
    pub message: T,
}

/// The messages of a recording, in the order of their log times.
#[derive(Debug)]
pub struct Records {
    window: Window,
    /// Part of the data section that was not read.
    left: Range<u64>,
    epoch_ns: i64,
    topics: Vec<Topic>,
    /// The definitions that were met up to here.
    pub(crate) definitions: Definitions,
    /// The present chunk, unpacked, and its messages that were not given.
    chunk: Arc<Vec<u8>>,
    entries: VecDeque<Entry>,
    damage: Vec<Damage>,
}

/// Reason why a chunk gives no more messages.
#[derive(Debug, thiserror::Error)]
enum BrokenChunk {
    #[error("it is longer than a chunk may be")]
    TooLong,
    #[error("a record in it is not whole")]
    Record,
    #[error("a message of `{}` in it is not as its type lays it out", .0.name())]
    Payload(Topic),
    #[error("its messages are not in the order of their log times")]
    Order,
    #[error("it declares another layout of `{0}`")]
    Layout(String),
    #[error(transparent)]
    Unpack(#[from] UnpackError),
    #[error(transparent)]
    File(#[from] io::Error),
}

impl From<Malformed> for BrokenChunk {
    fn from(_: Malformed) -> Self {
        Self::Record
    }
}

/// A message in the chunk's bytes.
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
        data: Range<u64>,
        topics: &[Topic],
    ) -> Self {
        Self {
            window: Window::new(source),
            left: data,
            epoch_ns,
            topics: topics.to_vec(),
            definitions: definitions.clone(),
            chunk: Arc::default(),
            entries: VecDeque::new(),
            damage: Vec::new(),
        }
    }

    /// Damage up to here.
    pub fn damage(&self) -> &[Damage] {
        &self.damage
    }

    /// Reads on until there are messages, or to the end of the data.
    fn fill(&mut self) {
        while self.entries.is_empty() && !self.left.is_empty() {
            let at = self.left.start;
            let (end, bytes, read) = match self.window.spot(at) {
                Ok(Some(spot)) => {
                    let is_chunk = spot.opcode == opcode::CHUNK;
                    let read = if is_chunk { self.take_chunk(spot) } else { Ok(()) };
                    (spot.end(), spot.end() - at, read)
                }
                Ok(None) => (self.left.end, 0, Ok(())),
                // The file is shorter than when it was opened.
                Err(error) => (self.left.end, self.left.end - at, Err(error.into())),
            };
            self.left.start = end;
            if let Err(reason) = read {
                let reason = reason.to_string();
                self.damage.push(Damage::Chunk { offset: at, bytes, reason });
            }
        }
    }

    /// Takes a chunk apart: definitions, and its messages up to the first damage.
    fn take_chunk(&mut self, spot: Spot) -> Result<(), BrokenChunk> {
        let length = usize::try_from(spot.length).ok().filter(|_| spot.length <= LONGEST_CHUNK);
        let body = self.window.bytes(spot.body(), length.ok_or(BrokenChunk::TooLong)?)?;
        let records = unpack(body)?;
        let whole = self.take_records(&records);
        self.chunk = Arc::new(records);
        whole
    }

    fn take_records(&mut self, bytes: &[u8]) -> Result<(), BrokenChunk> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let (opcode, body, behind) = format::record(rest)?;
            rest = behind;
            match format::parse(opcode, body)? {
                record @ (format::Record::Schema { .. } | format::Record::Channel(_)) => {
                    self.definitions.take(&record);
                    if let Some(topic) = self.definitions.other_layout() {
                        return Err(BrokenChunk::Layout(topic.to_owned()));
                    }
                }
                format::Record::Message { header: head, data: payload } => {
                    let asked = |topic: &Topic| self.topics.contains(topic);
                    let Some(topic) = self.definitions.topic(head.channel_id).filter(asked) else {
                        continue;
                    };
                    if !is_ours(topic, &payload) {
                        return Err(BrokenChunk::Payload(topic));
                    }
                    let end = bytes.len() - rest.len();
                    let range = end - topic.message_bytes()..end;
                    let (log_time, publish_time) = (head.log_time, head.publish_time);
                    if self.entries.back().is_some_and(|last| last.log_time > log_time) {
                        return Err(BrokenChunk::Order);
                    }
                    self.entries.push_back(Entry { topic, log_time, publish_time, range });
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Iterator for Records {
    type Item = Record;

    fn next(&mut self) -> Option<Record> {
        self.fill();
        let entry = self.entries.pop_front()?;
        Some(Record {
            topic: entry.topic,
            log_time_ns: run_time(entry.log_time, self.epoch_ns),
            publish_time_ns: run_time(entry.publish_time, self.epoch_ns),
            chunk: Arc::clone(&self.chunk),
            range: entry.range,
        })
    }
}

/// True if `payload` is a message of `topic` as we lay it out.
fn is_ours(topic: Topic, payload: &[u8]) -> bool {
    let body = payload.strip_prefix(&ENCAPSULATION);
    body.is_some_and(|body| body.len() == topic.message_bytes())
}

fn run_time(ns: u64, epoch_ns: i64) -> i64 {
    i64::try_from(i128::from(ns) - i128::from(epoch_ns)).unwrap_or(i64::MAX)
}
