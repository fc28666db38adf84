//! Writing a recording.

use crate::cdr::ENCAPSULATION;
use crate::definitions::{MESSAGE_ENCODING, SCHEMA_ENCODING};
use crate::scene::{self, Scene};
use crate::schema::ros2_definition_of;
use crate::{Metadata, Tally};
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions};
use messages::{Header, TOPICS, Topic};
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
    channels: BTreeMap<Topic, u16>,
    payload: Vec<u8>,
    epoch_ns: i64,
    /// Time when the file is flushed next, ns of run time; only in lockstep.
    flush_ns: Option<i64>,
    scene: Scene,
    scene_channels: [u16; scene::TOPICS.len()],
}

impl<W: Write + Seek> std::fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer").field("channels", &self.channels).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Writer<W> {
    /// Begins a recording: schemas, channels and `metadata`. Beside the messages it will hold the road
    /// as viewers draw it ([`scene`]).
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
            let definition = ros2_definition_of(layout, &metadata.law);
            let schema =
                inner.add_schema(layout.type_name, SCHEMA_ENCODING, definition.as_bytes())?;
            let channel =
                inner.add_channel(schema, topic.name(), MESSAGE_ENCODING, &BTreeMap::new())?;
            channels.insert(topic, channel);
        }
        let mut scene_channels = [0; scene::TOPICS.len()];
        for (topic, channel) in scene::TOPICS.iter().zip(&mut scene_channels) {
            let definition = topic.definition.as_bytes();
            let schema = inner.add_schema(topic.type_name, SCHEMA_ENCODING, definition)?;
            *channel = inner.add_channel(schema, topic.name, MESSAGE_ENCODING, &BTreeMap::new())?;
        }
        inner.flush()?;
        Ok(Self {
            inner,
            channels,
            payload: Vec::new(),
            epoch_ns: metadata.epoch_ns,
            flush_ns: (metadata.mode == Mode::Lockstep).then_some(FLUSH_PERIOD_NS),
            scene: Scene::of(metadata),
            scene_channels,
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
        assert_eq!(message.len(), topic.message_bytes(), "{}", topic.name());
        let head: Header = bytemuck::pod_read_unaligned(&message[..size_of::<Header>()]);
        self.payload.clear();
        self.payload.extend_from_slice(&ENCAPSULATION);
        self.payload.extend_from_slice(message);
        let header = MessageHeader {
            channel_id: self.channels[&topic],
            // The format's field is narrower than ours; the payload holds the whole number.
            sequence: head.sequence as u32,
            log_time: self.unix_ns(log_time_ns),
            publish_time: self.unix_ns(head.publish_ns),
        };
        if let Some(flush_ns) = self.flush_ns
            && log_time_ns >= flush_ns
        {
            self.inner.flush()?;
            self.flush_ns = Some((log_time_ns / FLUSH_PERIOD_NS + 1) * FLUSH_PERIOD_NS);
        }
        self.inner.write_to_known_channel(&header, &self.payload)?;
        let log_time = header.log_time;
        self.scene.take(topic, log_time_ns, message);
        for drawn in self.scene.drawn() {
            let header = MessageHeader {
                channel_id: self.scene_channels[drawn.topic],
                sequence: drawn.sequence,
                log_time,
                publish_time: log_time,
            };
            self.inner.write_to_known_channel(&header, &drawn.payload)?;
        }
        Ok(())
    }

    /// An instant of run time as the file's time, ns since 1970.
    fn unix_ns(&self, run_ns: i64) -> u64 {
        u64::try_from(self.epoch_ns.saturating_add(run_ns)).unwrap_or(0)
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
