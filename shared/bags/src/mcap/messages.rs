//! The messages of one topic, read from the front without index or summary.

use super::records::{self, HEAD, LONGEST_CHUNK, unpack};
use crate::{BagError, Encoding};
use ::mcap::MAGIC;
use ::mcap::records::{Record, op as opcode};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

/// Longest record outside chunks that is read, bytes.
const LONGEST_RECORD: u64 = 64 << 20;

/// Schemas seen so far: name, encoding and definition.
type Schemas = BTreeMap<u16, (String, String, String)>;

/// A topic's declaration in a file.
pub(crate) struct Connection<'a> {
    pub(crate) id: u16,
    pub(crate) topic: &'a str,
    pub(crate) type_name: &'a str,
    pub(crate) definition: &'a str,
    pub(crate) encoding: Encoding,
}

/// Receiver of a file's content.
pub(crate) trait Sink {
    /// A topic; the same one may come again.
    fn connection(&mut self, connection: Connection<'_>);
    fn message(&mut self, id: u16, log_time_ns: u64, payload: &[u8]) -> Result<(), BagError>;
}

/// Hands channels and messages of the file to `sink`, in their order in the file.
pub(crate) fn read(file: &mut (impl Read + Seek), sink: &mut dyn Sink) -> Result<(), BagError> {
    file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
    let mut schemas = Schemas::new();
    let mut head = [0; HEAD];
    loop {
        match file.read_exact(&mut head) {
            Ok(()) => {}
            // A recording that was cut off ends without its footer.
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(()),
            Err(error) => return Err(error.into()),
        }
        let (code, length) = records::head(&head);
        match code {
            opcode::FOOTER => return Ok(()),
            opcode::CHUNK => {
                let body = body(file, length, LONGEST_CHUNK)?;
                let unpacked = unpack(&body).map_err(BagError::chunk)?;
                let mut rest = unpacked.as_slice();
                while rest.len() >= HEAD {
                    let (code, body, behind) = records::record(rest)?;
                    record(code, body, &mut schemas, sink)?;
                    rest = behind;
                }
            }
            opcode::SCHEMA | opcode::CHANNEL | opcode::MESSAGE => {
                let body = body(file, length, LONGEST_RECORD)?;
                record(code, &body, &mut schemas, sink)?;
            }
            _ => {
                let length = i64::try_from(length).map_err(|_| BagError::malformed())?;
                file.seek(SeekFrom::Current(length))?;
            }
        }
    }
}

/// Reads a record's body. Nothing is allocated for bytes that the file does not have.
fn body(file: &mut impl Read, length: u64, longest: u64) -> Result<Vec<u8>, BagError> {
    if length > longest {
        return Err(BagError::chunk(format!("a record of {length} bytes; {longest} are read")));
    }
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(BagError::malformed()) }
}

fn record(
    code: u8,
    body: &[u8],
    schemas: &mut Schemas,
    sink: &mut dyn Sink,
) -> Result<(), BagError> {
    match records::parse(code, body)? {
        Record::Schema { header, data } => {
            let definition = String::from_utf8_lossy(&data).into_owned();
            schemas.insert(header.id, (header.name, header.encoding, definition));
        }
        Record::Channel(channel) => {
            let none = (String::new(), String::new(), String::new());
            let (type_name, language, definition) =
                schemas.get(&channel.schema_id).unwrap_or(&none);
            let encoding = match (&*channel.message_encoding, language.as_str()) {
                ("cdr", "ros2msg") => Encoding::Cdr,
                ("ros1", "ros1msg") => Encoding::Ros1,
                ("json", _) => Encoding::Json,
                (other, "") => Encoding::Other(other.to_owned()),
                (other, language) => Encoding::Other(format!("{other}, {language}")),
            };
            let (id, topic) = (channel.id, &*channel.topic);
            sink.connection(Connection { id, topic, type_name, definition, encoding });
        }
        Record::Message { header, data } => {
            sink.message(header.channel_id, header.log_time, &data)?;
        }
        _ => {}
    }
    Ok(())
}
