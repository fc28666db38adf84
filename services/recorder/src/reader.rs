//! Reading a recording, also one that was cut off.

use crate::counter::Counter;
use crate::scan::{Entry, Scan};
use crate::{Damage, FILE, Metadata, ReadError, Tally};
use messages::{Header, Message, Topic};
use std::path::{Path, PathBuf};

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
        let scan = Scan::of(body);
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
