//! ROS 1 bags of version 2.0 (<https://wiki.ros.org/Bags/Format/2.0>).
//!
//! ```text
//! file:    "#ROSBAG V2.0\n", record*
//! record:  header length u32, header, data length u32, data
//! header:  (field length u32, name "=" value)*
//! chunk:   a record whose data, out of its compression, are records of connections and messages
//! ```

use crate::sink::{Connection, Sink};
use crate::{BagError, Encoding};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

/// First bytes of a file.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Longest header, data of a message and unpacked chunk that are read, bytes.
const LONGEST_HEADER: u32 = 1 << 20;
const LONGEST_DATA: u32 = 64 << 20;

/// Kinds of record that are read.
const MESSAGE: u8 = 0x02;
const CHUNK: u8 = 0x05;
const CONNECTION: u8 = 0x07;

/// Fields of a header by name.
type Header = BTreeMap<String, Vec<u8>>;

/// Hands connections and messages of the file to `sink`, in their order in the file.
pub(crate) fn read(file: &mut (impl Read + Seek), sink: &mut dyn Sink) -> Result<(), BagError> {
    let mut magic = [0; MAGIC.len()];
    file.read_exact(&mut magic)?;
    loop {
        let mut length = [0; 4];
        match file.read_exact(&mut length) {
            Ok(()) => {}
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(()),
            Err(error) => return Err(error.into()),
        }
        let header = header(&take(file, u32::from_le_bytes(length), LONGEST_HEADER)?)?;
        file.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length);
        match opcode(&header)? {
            CHUNK => chunk(&header, &take(file, length, LONGEST_DATA)?, sink)?,
            CONNECTION | MESSAGE => record(&header, &take(file, length, LONGEST_DATA)?, sink)?,
            _ => {
                file.seek(SeekFrom::Current(i64::from(length)))?;
            }
        }
    }
}

/// Reads `length` bytes. Nothing is allocated for bytes that the file does not have.
fn take(file: &mut impl Read, length: u32, longest: u32) -> Result<Vec<u8>, BagError> {
    if length > longest {
        return Err(BagError::Chunk(format!("a record of {length} bytes; {longest} are read")));
    }
    let mut bytes = Vec::new();
    file.take(u64::from(length)).read_to_end(&mut bytes)?;
    if bytes.len() == length as usize { Ok(bytes) } else { Err(BagError::Malformed) }
}

/// Takes bytes with their length, 32 bits, before them.
fn block<'a>(bytes: &mut &'a [u8]) -> Result<&'a [u8], BagError> {
    let (length, rest) = bytes.split_first_chunk().ok_or(BagError::Malformed)?;
    let length = u32::from_le_bytes(*length) as usize;
    let (block, rest) = rest.split_at_checked(length).ok_or(BagError::Malformed)?;
    *bytes = rest;
    Ok(block)
}

fn header(mut bytes: &[u8]) -> Result<Header, BagError> {
    let mut header = Header::new();
    while !bytes.is_empty() {
        let field = block(&mut bytes)?;
        let equals = field.iter().position(|byte| *byte == b'=').ok_or(BagError::Malformed)?;
        let name = String::from_utf8_lossy(&field[..equals]).into_owned();
        header.insert(name, field[equals + 1..].to_vec());
    }
    Ok(header)
}

fn field<'a>(header: &'a Header, name: &str) -> Result<&'a [u8], BagError> {
    header.get(name).map(Vec::as_slice).ok_or(BagError::Malformed)
}

fn text(header: &Header, name: &str) -> Result<String, BagError> {
    field(header, name).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
}

fn word(bytes: &[u8]) -> Result<u32, BagError> {
    bytes.try_into().map(u32::from_le_bytes).map_err(|_| BagError::Malformed)
}

fn opcode(header: &Header) -> Result<u8, BagError> {
    field(header, "op")?.first().copied().ok_or(BagError::Malformed)
}

fn chunk(of: &Header, packed: &[u8], sink: &mut dyn Sink) -> Result<(), BagError> {
    let size = word(field(of, "size")?)?;
    if size > LONGEST_DATA {
        return Err(BagError::Chunk(format!("a chunk of {size} bytes; {LONGEST_DATA} are read")));
    }
    let mut unpacked = Vec::new();
    let mut rest = match text(of, "compression")?.as_str() {
        "none" => packed,
        "lz4" => {
            let damaged = |error: std::io::Error| BagError::Chunk(error.to_string());
            let decoder = lz4::Decoder::new(packed).map_err(damaged)?;
            decoder.take(u64::from(size) + 1).read_to_end(&mut unpacked).map_err(damaged)?;
            if unpacked.len() != size as usize {
                return Err(BagError::Malformed);
            }
            &unpacked
        }
        other => {
            let said = format!("its compression is {other}; `rosbag decompress` unpacks the file");
            return Err(BagError::Chunk(said));
        }
    };
    while !rest.is_empty() {
        let header = header(block(&mut rest)?)?;
        let data = block(&mut rest)?;
        record(&header, data, sink)?;
    }
    Ok(())
}

fn record(of: &Header, data: &[u8], sink: &mut dyn Sink) -> Result<(), BagError> {
    match opcode(of)? {
        CONNECTION => {
            let about = header(data)?;
            sink.connection(Connection {
                id: word(field(of, "conn")?)?,
                topic: &text(of, "topic")?,
                type_name: &text(&about, "type")?,
                definition: &text(&about, "message_definition")?,
                encoding: Encoding::Ros1,
            });
        }
        MESSAGE => {
            let mut time = field(of, "time")?;
            let mut next = || -> Result<u64, BagError> {
                let (now, rest) = time.split_first_chunk::<4>().ok_or(BagError::Malformed)?;
                time = rest;
                Ok(u64::from(u32::from_le_bytes(*now)))
            };
            let (seconds, nanoseconds) = (next()?, next()?);
            let time_ns = seconds * 1_000_000_000 + nanoseconds;
            sink.message(word(field(of, "conn")?)?, time_ns, data)?;
        }
        _ => {}
    }
    Ok(())
}
