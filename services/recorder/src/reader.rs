//! Reading a recording, also one that was cut off.

use crate::counter::Counter;
use crate::writer::ENCAPSULATION;
use crate::{FILE, Metadata, Tally, schema};
use mcap::records::{self, Record as Raw};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use shared::messages::{Header, Message, Topic};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Bytes of a record before its body: opcode and length.
const RECORD_HEAD: usize = 9;
/// Longest record in a chunk that is believed, bytes: a damaged length must not ask for gigabytes.
const LONGEST_RECORD: usize = 16 << 20;

/// Why a file cannot be read as a recording at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It cannot be opened.
    #[error("cannot read {}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// It is no recording of timegap.
    #[error("{} is not a recording of timegap: {reason}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// Its messages have other layouts than this program's.
    #[error(
        "{} was recorded by {program} with other messages (`{topic}` differs): read it with that \
         version", path.display()
    )]
    Layout {
        /// The file.
        path: PathBuf,
        /// Who recorded it.
        program: String,
        /// A topic whose schema differs.
        topic: String,
    },
}

/// A part of a recording that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Damage {
    /// The file ends before its end: the recorder was killed, or the disk was full.
    CutOff {
        /// Bytes behind the last whole record.
        bytes: u64,
    },
    /// A chunk in the middle is damaged and was left out.
    Chunk {
        /// Where it is in the file.
        offset: u64,
        /// Its length, bytes.
        bytes: u64,
        /// What is wrong with it.
        reason: String,
    },
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CutOff { bytes: 0 } => f.write_str("the recording was never ended"),
            Self::CutOff { bytes } => {
                write!(f, "the recording was never ended; its last {bytes} bytes are no whole part")
            }
            Self::Chunk { offset, bytes, reason } => {
                write!(f, "{bytes} bytes from byte {offset} on are damaged ({reason})")
            }
        }
    }
}

/// One recorded message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// The topic.
    pub topic: Topic,
    /// When the recorder took it, ns of run time; in lockstep, when it was published.
    pub log_time_ns: i64,
    /// When its sender published it, ns of run time.
    pub publish_time_ns: i64,
    /// The bytes of the topic's struct.
    pub bytes: &'a [u8],
}

impl Record<'_> {
    /// The header that every message starts with.
    #[must_use]
    pub fn header(&self) -> Header {
        bytemuck::pod_read_unaligned(&self.bytes[..size_of::<Header>()])
    }

    /// The message, if `T` is the topic's type.
    #[must_use]
    pub fn message<T: Message>(&self) -> Option<T> {
        (self.topic == T::TOPIC).then(|| bytemuck::pod_read_unaligned(self.bytes))
    }
}

/// A message with the time at which it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed<T> {
    /// When the recorder took it, ns of run time; in lockstep, when it was published.
    pub log_time_ns: i64,
    /// The message.
    pub message: T,
}

/// Where a message is in [`Recording::payload`].
#[derive(Clone, Copy, Debug)]
struct Entry {
    topic: Topic,
    log_time_ns: i64,
    publish_time_ns: i64,
    offset: usize,
}

/// A recording in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    path: PathBuf,
    file_bytes: u64,
    metadata: Metadata,
    tally: Option<Tally>,
    damage: Vec<Damage>,
    entries: Vec<Entry>,
    payload: Vec<u8>,
}

impl Recording {
    /// Reads the recording at `path`, a file or a run's directory of results, as far as it goes.
    ///
    /// # Errors
    /// If there is no file, or it is no recording, or one with other messages. A file that ends too
    /// early is no error: see [`Recording::damage`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let path = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
        if std::fs::metadata(&path).is_ok_and(|file| !file.is_file()) {
            let reason = "it is no regular file".into();
            return Err(ReadError::Foreign { path, reason });
        }
        let file = std::fs::read(&path)
            .map_err(|reason| ReadError::File { path: path.clone(), reason })?;
        Self::of_bytes(path, &file)
    }

    /// Reads a recording whose file, known as `path`, has these contents.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn of_bytes(path: PathBuf, file: &[u8]) -> Result<Self, ReadError> {
        let foreign =
            |reason: &str| ReadError::Foreign { path: path.clone(), reason: reason.into() };
        let body = file.strip_prefix(mcap::MAGIC).ok_or_else(|| foreign("it is no MCAP file"))?;
        let mut scan = Scan::default();
        let mut at = 0;
        let mut ended = false;
        while !ended && let Some(length) = whole_record(&body[at..]) {
            let record = &body[at..at + length];
            match mcap::read::parse_record(record[0], &record[RECORD_HEAD..]) {
                Ok(Raw::DataEnd(_)) => ended = true,
                Ok(Raw::Chunk { .. }) => {
                    let before = (scan.entries.len(), scan.payload.len());
                    if let Err(error) = scan.chunk(record) {
                        // The sum comes last: nothing of the chunk can be believed.
                        scan.entries.truncate(before.0);
                        scan.payload.truncate(before.1);
                        let offset = (mcap::MAGIC.len() + at) as u64;
                        let bytes = length as u64;
                        scan.damage.push(Damage::Chunk {
                            offset,
                            bytes,
                            reason: error.to_string(),
                        });
                    }
                }
                Ok(other) => scan.record(other),
                // A record of nonsense: whatever follows was not written by a recorder.
                Err(_) => break,
            }
            at += length;
        }
        if !ended {
            scan.damage.push(Damage::CutOff { bytes: (body.len() - at) as u64 });
        }
        let metadata = scan.metadata.ok_or_else(|| foreign("it does not say of which run"))?;
        if let Some(topic) = scan.other_layout {
            return Err(ReadError::Layout { path, program: metadata.program, topic });
        }
        Ok(Self {
            path,
            file_bytes: file.len() as u64,
            metadata,
            tally: scan.tally,
            damage: scan.damage,
            entries: scan.entries,
            payload: scan.payload,
        })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its size, bytes.
    #[must_use]
    pub fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// What is known of the run.
    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// What the recorder counted; `None` if it never ended the recording.
    #[must_use]
    pub fn tally(&self) -> Option<&Tally> {
        self.tally.as_ref()
    }

    /// What could not be read; empty for a whole recording.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        &self.damage
    }

    /// All messages in the order in which they were recorded: that of each sender on each topic,
    /// and nearly that of time between topics.
    pub fn records(&self) -> impl ExactSizeIterator<Item = Record<'_>> + Clone {
        self.entries.iter().map(|entry| Record {
            topic: entry.topic,
            log_time_ns: entry.log_time_ns,
            publish_time_ns: entry.publish_time_ns,
            bytes: &self.payload[entry.offset..entry.offset + entry.topic.message_bytes()],
        })
    }

    /// All messages of `T`'s topic.
    pub fn messages<T: Message>(&self) -> impl Iterator<Item = Timed<T>> + '_ {
        self.records().filter_map(|record| {
            let message = record.message()?;
            Some(Timed { log_time_ns: record.log_time_ns, message })
        })
    }

    /// Messages in the file and gaps in their sequence numbers, counted anew: for a file whose
    /// recorder did not live to say.
    #[must_use]
    pub fn count(&self) -> Tally {
        let mut counter = Counter::default();
        self.records().for_each(|record| counter.count(record.topic, record.bytes));
        counter.tally()
    }

    /// Newest publish time of any message, ns of run time.
    #[must_use]
    pub fn end_ns(&self) -> i64 {
        self.entries.iter().map(|entry| entry.publish_time_ns).max().unwrap_or(0)
    }
}

/// Length of the record at the start of `bytes`, if all of it is there.
fn whole_record(bytes: &[u8]) -> Option<usize> {
    let length = bytes.get(1..RECORD_HEAD)?;
    let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
    let length = usize::try_from(length).ok()?.checked_add(RECORD_HEAD)?;
    (length <= bytes.len()).then_some(length)
}

/// What was found so far.
#[derive(Default)]
struct Scan {
    metadata: Option<Metadata>,
    tally: Option<Tally>,
    damage: Vec<Damage>,
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Topic>,
    other_layout: Option<String>,
    entries: Vec<Entry>,
    payload: Vec<u8>,
}

impl Scan {
    /// Takes a chunk apart after checking its sum; `record` is the whole record.
    fn chunk(&mut self, record: &[u8]) -> Result<(), mcap::McapError> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(LONGEST_RECORD);
        let mut reader = LinearReader::new_with_options(options);
        let mut rest = record;
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let (now, later) = rest.split_at(wanted.min(rest.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    rest = later;
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.record(mcap::read::parse_record(opcode, data)?);
                }
            }
        }
        Ok(())
    }

    fn record(&mut self, record: Raw<'_>) {
        match record {
            Raw::Metadata(record) => {
                self.metadata = self.metadata.take().or_else(|| Metadata::of_record(&record));
                self.tally = self.tally.take().or_else(|| Tally::of_record(&record));
            }
            Raw::Schema { header, data } => {
                self.schemas.insert(header.id, data.into_owned());
            }
            Raw::Channel(channel) => self.channel(&channel),
            Raw::Message { header, data } => self.message(&header, &data),
            _ => {}
        }
    }

    fn channel(&mut self, channel: &records::Channel) {
        // A topic that others added to the file is theirs.
        let Some(topic) = Topic::by_name(&channel.topic) else { return };
        let ours = schema::ros2_definition(topic.layout());
        if self.schemas.get(&channel.schema_id).is_some_and(|theirs| *theirs == ours.as_bytes()) {
            self.channels.insert(channel.id, topic);
        } else {
            self.other_layout.get_or_insert_with(|| channel.topic.clone());
        }
    }

    fn message(&mut self, header: &records::MessageHeader, data: &[u8]) {
        let Some(&topic) = self.channels.get(&header.channel_id) else { return };
        let Some(body) = data.strip_prefix(&ENCAPSULATION) else { return };
        if body.len() != topic.message_bytes() {
            return;
        }
        self.entries.push(Entry {
            topic,
            log_time_ns: i64::try_from(header.log_time).unwrap_or(i64::MAX),
            publish_time_ns: i64::try_from(header.publish_time).unwrap_or(i64::MAX),
            offset: self.payload.len(),
        });
        self.payload.extend_from_slice(body);
    }
}
