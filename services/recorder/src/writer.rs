//! Writing a recording.

use crate::schema::ros2_definition;
use crate::{Metadata, Tally};
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions};
use messages::{Header, TOPICS, Topic};
use std::collections::BTreeMap;
use std::io::{BufWriter, Seek, Write};

/// Little-endian CDR without options: what precedes every body.
pub(crate) const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Uncompressed size of a chunk, the unit in which a file grows.
const CHUNK_BYTES: u64 = 64 * 1024;

/// Writes messages to an MCAP file. What was flushed survives the process.
pub struct Writer<W: Write + Seek> {
    inner: mcap::Writer<BufWriter<W>>,
    channels: BTreeMap<Topic, u16>,
    payload: Vec<u8>,
}

impl<W: Write + Seek> std::fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer").field("channels", &self.channels).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a recording: schemas, channels and `metadata`.
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
        let mut channels = BTreeMap::new();
        for topic in TOPICS {
            let layout = topic.layout();
            let definition = ros2_definition(layout);
            let schema = inner.add_schema(layout.type_name, "ros2msg", definition.as_bytes())?;
            let channel = inner.add_channel(schema, topic.name(), "cdr", &BTreeMap::new())?;
            channels.insert(topic, channel);
        }
        inner.flush()?;
        Ok(Self { inner, channels, payload: Vec::new() })
    }

    /// Adds a message: the bytes of `topic`'s struct, and when the recorder took it, ns of run
    /// time.
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
        assert_eq!(message.len(), topic.message_bytes(), "{}", topic.name());
        let head: Header = bytemuck::pod_read_unaligned(&message[..size_of::<Header>()]);
        self.payload.clear();
        self.payload.extend_from_slice(&ENCAPSULATION);
        self.payload.extend_from_slice(message);
        let header = MessageHeader {
            channel_id: self.channels[&topic],
            // The format's field is narrower than ours; the payload holds the whole number.
            sequence: head.sequence as u32,
            log_time: u64::try_from(log_time_ns).unwrap_or(0),
            publish_time: u64::try_from(head.publish_ns).unwrap_or(0),
        };
        self.inner.write_to_known_channel(&header, &self.payload)
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
