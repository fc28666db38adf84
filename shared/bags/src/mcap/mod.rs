//! MCAP: records as they stand in a file, chunks out of their compression, messages one after another.

mod messages;
mod records;
mod unpack;

pub(crate) use messages::{Connection, Sink, read};
pub use records::{
    Channel, Chunk, Fields, HEAD, MAGIC, MESSAGE_HEAD, Malformed, MessageHead, Schema, Statistics,
    channel, chunk, head, message, metadata, opcode, record, schema, statistics,
};
pub use unpack::{LONGEST_CHUNK, UnpackError, unpack};
