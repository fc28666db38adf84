//! Going through the records of a file, whole or not.

use crate::writer::ENCAPSULATION;
use crate::{Damage, Metadata, Tally, schema};
use mcap::records::{self, Record as Raw};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use messages::Topic;
use std::collections::BTreeMap;

/// Bytes of a record before its body: opcode and length.
const RECORD_HEAD: usize = 9;
/// Longest record in a chunk that is believed, bytes: a damaged length must not ask for gigabytes.
const LONGEST_RECORD: usize = 16 << 20;

/// Where a message is in the payload.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) topic: Topic,
    pub(crate) log_time_ns: i64,
    pub(crate) publish_time_ns: i64,
    pub(crate) offset: usize,
}

/// What was found so far.
#[derive(Default)]
pub(crate) struct Scan {
    pub(crate) metadata: Option<Metadata>,
    pub(crate) tally: Option<Tally>,
    pub(crate) damage: Vec<Damage>,
    /// A topic whose messages have another layout than this program's.
    pub(crate) other_layout: Option<String>,
    pub(crate) entries: Vec<Entry>,
    pub(crate) payload: Vec<u8>,
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Topic>,
}

impl Scan {
    /// Reads the records behind the magic bytes, as far as they go.
    pub(crate) fn of(body: &[u8]) -> Self {
        let mut scan = Self::default();
        let mut at = 0;
        let mut ended = false;
        while !ended && let Some(length) = whole_record(&body[at..]) {
            let record = &body[at..at + length];
            match mcap::read::parse_record(record[0], &record[RECORD_HEAD..]) {
                Ok(Raw::DataEnd(_)) => ended = true,
                Ok(Raw::Chunk { .. }) => scan.chunk(record, (mcap::MAGIC.len() + at) as u64),
                Ok(other) => scan.record(other),
                // A record of nonsense: whatever follows was not written by a recorder.
                Err(_) => break,
            }
            at += length;
        }
        if !ended {
            scan.damage.push(Damage::CutOff { bytes: (body.len() - at) as u64 });
        }
        scan
    }

    /// Takes the chunk at `offset` of the file; `record` is the whole record.
    fn chunk(&mut self, record: &[u8], offset: u64) {
        let (entries, payload) = (self.entries.len(), self.payload.len());
        if let Err(error) = self.unpack(record) {
            // The sum comes last: nothing of the chunk can be believed.
            self.entries.truncate(entries);
            self.payload.truncate(payload);
            let (bytes, reason) = (record.len() as u64, error.to_string());
            self.damage.push(Damage::Chunk { offset, bytes, reason });
        }
    }

    /// Takes a chunk apart and checks its sum.
    fn unpack(&mut self, record: &[u8]) -> Result<(), mcap::McapError> {
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

/// Length of the record at the start of `bytes`, if all of it is there.
fn whole_record(bytes: &[u8]) -> Option<usize> {
    let length = bytes.get(1..RECORD_HEAD)?;
    let length = u64::from_le_bytes(length.try_into().expect("eight bytes"));
    let length = usize::try_from(length).ok()?.checked_add(RECORD_HEAD)?;
    (length <= bytes.len()).then_some(length)
}
