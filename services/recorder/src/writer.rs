//! Writing a recording, also what is readable of a broken one.

use crate::counter::Counter;
use crate::definitions::{MESSAGE_ENCODING, SCHEMA_ENCODING};
use crate::{Encoder, Metadata, Recording, Survey, Tally};
use mcap::{Compression, McapError, Summary, WriteOptions};
use messages::Topic;
use runtime::Mode;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Seek, Write};

/// Uncompressed size of a chunk, the unit in which a file grows. A second brings less, so that a flush ends most of
/// them. The writer keeps an index of every chunk, some 1.1 KiB, until the end.
const CHUNK_BYTES: u64 = 4 * 1024 * 1024;
/// Simulated time after which a lockstep recording is flushed, ns.
const FLUSH_PERIOD_NS: i64 = 1_000_000_000;

/// Writes messages to an MCAP file. Flushed messages survive the process.
pub struct Writer<W: Write + Seek> {
    inner: mcap::Writer<BufWriter<W>>,
    /// The file's numbers of the encoder's channels.
    channels: Vec<u16>,
    /// Time when the file is flushed next, ns of run time; only in lockstep.
    flush_ns: Option<i64>,
    encoder: Encoder,
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a recording: schemas, channels and `metadata`. Beside the messages it will hold the road
    /// as viewers draw it ([`crate::scene`]).
    ///
    /// # Errors
    /// If `file` cannot be written.
    pub fn begin(file: W, metadata: &Metadata) -> Result<Self, McapError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(format!("{} {}", metadata.program, mcap::LIBRARY_IDENTIFIER))
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk is written when it is whole, so that a file is readable wherever it ends.
            .disable_seeking(true);
        let mut inner = options.create(BufWriter::new(file))?;
        inner.write_metadata(&metadata.to_record())?;
        let mut channels = Vec::new();
        for channel in Encoder::channels(metadata) {
            let definition = channel.definition.as_bytes();
            let schema = inner.add_schema(channel.type_name, SCHEMA_ENCODING, definition)?;
            let none = BTreeMap::new();
            channels.push(inner.add_channel(schema, channel.topic, MESSAGE_ENCODING, &none)?);
        }
        inner.flush()?;
        Ok(Self {
            inner,
            channels,
            flush_ns: (metadata.mode == Mode::Lockstep).then_some(FLUSH_PERIOD_NS),
            encoder: Encoder::of(metadata),
        })
    }

    /// Adds a message: the bytes of `topic`'s struct, and its time, ns of run time, which must not go back.
    ///
    /// # Errors
    /// If the file cannot be written.
    ///
    /// # Panics
    /// If `message` is not as long as the topic's struct.
    pub fn message(
        &mut self,
        topic: Topic,
        log_time_ns: i64,
        message: &[u8],
    ) -> Result<(), McapError> {
        if let Some(flush_ns) = self.flush_ns
            && log_time_ns >= flush_ns
        {
            self.inner.flush()?;
            self.flush_ns =
                Some((log_time_ns / FLUSH_PERIOD_NS + 1).saturating_mul(FLUSH_PERIOD_NS));
        }
        let Self { inner, channels, encoder, .. } = self;
        encoder.encode(topic, log_time_ns, message, |mut head, payload| {
            head.channel_id = channels[usize::from(head.channel_id)];
            inner.write_to_known_channel(&head, payload)
        })
    }

    /// Hands everything so far to the system.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<(), McapError> {
        self.inner.flush()
    }

    /// Ends the recording with what was counted, the index and the summary, which it returns.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(mut self, tally: &Tally) -> Result<Summary, McapError> {
        self.inner.write_metadata(&tally.to_record())?;
        let summary = self.inner.finish()?;
        self.inner.into_inner().flush()?;
        Ok(summary)
    }
}

/// Writes what is readable of `recording` to `file` as a whole recording. Returns the content and the summary of the new
/// file, and the damage of the old one.
///
/// # Errors
/// If `file` cannot be written.
pub fn recover<W: Write + Seek>(recording: &Recording, file: W) -> io::Result<(Survey, Summary)> {
    rewrite(recording, file).map_err(|error| match error {
        // The system's own reason: a full disk differs from a bad file.
        McapError::Io(reason) => reason,
        error => io::Error::other(error),
    })
}

fn rewrite<W: Write + Seek>(
    recording: &Recording,
    file: W,
) -> Result<(Survey, Summary), McapError> {
    let metadata = recording.metadata();
    // An older recording gets today's log times.
    let metadata = Metadata { epoch_ns: metadata.started_unix_ns, ..metadata.clone() };
    let mut writer = Writer::begin(file, &metadata)?;
    let mut counter = Counter::default();
    let mut end_ns = 0;
    let mut records = recording.records();
    for record in records.by_ref() {
        writer.message(record.topic, record.log_time_ns, record.bytes())?;
        counter.count(record.topic, record.bytes());
        end_ns = end_ns.max(record.log_time_ns);
    }
    let tally = counter.tally();
    let summary = writer.finish(&tally)?;
    let damage = [recording.damage(), records.damage()].concat();
    Ok((Survey { tally, end_ns, damage }, summary))
}
