//! Taking a chunk out of its compression, within bounds.

use super::records::parse;
use ::mcap::records::{Record, op};
use std::io::Read;

/// Longest chunk that is read, bytes unpacked and packed.
pub const LONGEST_CHUNK: u64 = 64 << 20;

/// Reason why a chunk cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum UnpackError {
    #[error("its lengths do not fit")]
    Lengths,
    #[error("it unpacks to {0} bytes; a chunk may have {LONGEST_CHUNK}")]
    TooLong(u64),
    #[error("it is longer than the {0} bytes that it says")]
    Longer(u64),
    #[error("it has {0} bytes of the {1} that it says")]
    Shorter(u64, u64),
    #[error("its compression is `{0}`, expected `lz4`, `zstd` or none")]
    Compression(String),
    #[error("its {0} data is damaged: {1}")]
    Damaged(&'static str, String),
    #[error("its checksum is wrong")]
    Checksum,
}

/// Unpacks the records of a chunk with this body.
///
/// # Errors
/// If the chunk is too long, damaged or packed in another way.
pub fn unpack(body: &[u8]) -> Result<Vec<u8>, UnpackError> {
    let Ok(Record::Chunk { header: chunk, data }) = parse(op::CHUNK, body) else {
        return Err(UnpackError::Lengths);
    };
    let (packed, length) = (&*data, chunk.uncompressed_size);
    if length > LONGEST_CHUNK {
        return Err(UnpackError::TooLong(length));
    }
    let records = match &*chunk.compression {
        "" => bounded("plain", Ok::<_, std::io::Error>(packed), length),
        "lz4" => bounded("lz4", lz4::Decoder::new(packed), length),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            bounded("zstd", decoder, length)
        }
        other => Err(UnpackError::Compression(other.chars().take(20).collect())),
    }?;
    if chunk.uncompressed_crc != 0 && crc32fast::hash(&records) != chunk.uncompressed_crc {
        return Err(UnpackError::Checksum);
    }
    Ok(records)
}

/// Reads `length` bytes, and makes sure that there are no more.
fn bounded<R: Read, E: std::fmt::Display>(
    name: &'static str,
    reader: Result<R, E>,
    length: u64,
) -> Result<Vec<u8>, UnpackError> {
    let reader = reader.map_err(|error| UnpackError::Damaged(name, error.to_string()))?;
    let capacity = usize::try_from(length).map_err(|_| UnpackError::TooLong(length))?;
    let mut records = Vec::with_capacity(capacity);
    reader
        .take(length + 1)
        .read_to_end(&mut records)
        .map_err(|error| UnpackError::Damaged(name, error.to_string()))?;
    match records.len() as u64 {
        longer if longer > length => Err(UnpackError::Longer(length)),
        shorter if shorter < length => Err(UnpackError::Shorter(shorter, length)),
        _ => Ok(records),
    }
}
