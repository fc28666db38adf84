//! The messages of one topic, read from the front without index or summary.

use super::records::{self, HEAD, MAGIC, opcode};
use super::unpack::{LONGEST_CHUNK, unpack};
use crate::sink::{Connection, Sink};
use crate::{BagError, Encoding};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

/// Longest record outside chunks that is read, bytes.
const LONGEST_RECORD: u64 = 64 << 20;

/// Schemas seen so far: name, encoding and definition.
type Schemas = BTreeMap<u16, (String, String, String)>;

/// Hands channels and messages of the file to `sink`, in their order in the file.
pub(crate) fn read(file: &mut (impl Read + Seek), sink: &mut dyn Sink) -> Result<(), BagError> {
    let mut magic = [0; MAGIC.len()];
    file.read_exact(&mut magic)?;
    let mut schemas = Schemas::new();
    let mut head = [0; HEAD];
    loop {
        match file.read_exact(&mut head) {
            Ok(()) => {}
            // A recording that was cut off ends without its footer.
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(()),
            Err(error) => return Err(error.into()),
        }
        let (code, length) = records::head(&head).map_err(|_| BagError::Malformed)?;
        match code {
            opcode::FOOTER => return Ok(()),
            opcode::CHUNK => {
                let body = body(file, length, LONGEST_CHUNK)?;
                let chunk = records::chunk(&body).map_err(|_| BagError::Malformed)?;
                let unpacked =
                    unpack(&chunk).map_err(|error| BagError::Chunk(error.to_string()))?;
                let mut rest = unpacked.as_slice();
                while let Some((head, behind)) = rest.split_at_checked(HEAD) {
                    let (code, length) = records::head(head).map_err(|_| BagError::Malformed)?;
                    let length = usize::try_from(length).map_err(|_| BagError::Malformed)?;
                    let (body, behind) =
                        behind.split_at_checked(length).ok_or(BagError::Malformed)?;
                    record(code, body, &mut schemas, sink)?;
                    rest = behind;
                }
            }
            opcode::SCHEMA | opcode::CHANNEL | opcode::MESSAGE => {
                let body = body(file, length, LONGEST_RECORD)?;
                record(code, &body, &mut schemas, sink)?;
            }
            _ => {
                let length = i64::try_from(length).map_err(|_| BagError::Malformed)?;
                file.seek(SeekFrom::Current(length))?;
            }
        }
    }
}

/// Reads a record's body. Nothing is allocated for bytes that the file does not have.
fn body(file: &mut impl Read, length: u64, longest: u64) -> Result<Vec<u8>, BagError> {
    if length > longest {
        return Err(BagError::Chunk(format!("a record of {length} bytes; {longest} are read")));
    }
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(BagError::Malformed) }
}

fn record(
    code: u8,
    body: &[u8],
    schemas: &mut Schemas,
    sink: &mut dyn Sink,
) -> Result<(), BagError> {
    match code {
        opcode::SCHEMA => {
            let schema = records::schema(body).map_err(|_| BagError::Malformed)?;
            let definition = String::from_utf8_lossy(schema.definition).into_owned();
            schemas.insert(schema.id, (schema.name.into(), schema.encoding.into(), definition));
        }
        opcode::CHANNEL => {
            let channel = records::channel(body).map_err(|_| BagError::Malformed)?;
            let none = (String::new(), String::new(), String::new());
            let (type_name, language, definition) = schemas.get(&channel.schema).unwrap_or(&none);
            let encoding = match (channel.encoding, language.as_str()) {
                ("cdr", "ros2msg") => Encoding::Cdr,
                ("ros1", "ros1msg") => Encoding::Ros1,
                ("json", _) => Encoding::Json,
                (other, language) => Encoding::Other(match language {
                    "" => other.to_owned(),
                    language => format!("{other}, {language}"),
                }),
            };
            sink.connection(Connection {
                id: u32::from(channel.id),
                topic: channel.topic,
                type_name,
                definition,
                encoding,
            });
        }
        opcode::MESSAGE => {
            let (head, payload) = records::message(body).map_err(|_| BagError::Malformed)?;
            sink.message(u32::from(head.channel), head.log_time, payload)?;
        }
        _ => {}
    }
    Ok(())
}
