//! Writing a recording.

use crate::definitions::{MESSAGE_ENCODING, SCHEMA_ENCODING};
use crate::{Encoder, Metadata, Tally};
use mcap::{Compression, McapError, WriteOptions};
use messages::Topic;
use runtime::Mode;
use std::collections::BTreeMap;
use std::io::{BufWriter, Seek, Write};

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
            self.flush_ns = Some((log_time_ns / FLUSH_PERIOD_NS + 1) * FLUSH_PERIOD_NS);
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

    /// Ends the recording with what was counted, the index and the summary.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(mut self, tally: &Tally) -> Result<(), McapError> {
        self.inner.write_metadata(&tally.to_record())?;
        self.inner.finish()?;
        self.inner.into_inner().flush()?;
        Ok(())
    }
}
