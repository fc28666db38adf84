//! MCAP: records as they stand in a file, chunks out of their compression, messages one after another.

mod messages;
mod records;

pub use ::mcap::MAGIC;
pub use ::mcap::records::{Record, op as opcode};
pub(crate) use messages::{Connection, Sink, read};
pub use records::{HEAD, LONGEST_CHUNK, Malformed, UnpackError, head, parse, record, unpack};
