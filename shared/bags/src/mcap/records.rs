//! MCAP records as they stand in a file (<https://mcap.dev/spec>). Every length is checked, as a
//! file may come from another program or an attacker.
//!
//! ```text
//! magic, record*, magic        record: opcode u8, length u64, body
//! ```
//!
//! All numbers are little-endian. The library `mcap` reads the bodies. Nothing allocates what a length in the file asks
//! for, and a chunk is unpacked within bounds.

use ::mcap::records::{Record, op};
use std::io::Read;

/// Bytes of a record before its body: opcode and length.
pub const HEAD: usize = 9;

/// A record is shorter than its stated content, or has no text where one belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// Reads opcode and length of the body of a record that begins with `head`.
pub fn head(head: &[u8; HEAD]) -> (u8, u64) {
    let [opcode, length @ ..] = *head;
    (opcode, u64::from_le_bytes(length))
}

/// Takes the record at the start of `bytes` apart: opcode and body, and the bytes behind it.
pub fn record(bytes: &[u8]) -> Result<(u8, &[u8], &[u8]), Malformed> {
    let (start, rest) = bytes.split_first_chunk().ok_or(Malformed)?;
    let (opcode, length) = head(start);
    let length = usize::try_from(length).map_err(|_| Malformed)?;
    let (body, behind) = rest.split_at_checked(length).ok_or(Malformed)?;
    Ok((opcode, body, behind))
}

/// Reads the body of a record, if it is of a kind that is used.
pub fn parse(opcode: u8, body: &[u8]) -> Result<Record<'_>, Malformed> {
    match opcode {
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::STATISTICS | op::METADATA => {
            ::mcap::parse_record(opcode, body).map_err(|_| Malformed)
        }
        // The library does not survive each short body of the others.
        _ => Ok(Record::Unknown { opcode, data: body.into() }),
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_end_is_refused() {
        let refused = |opcode, body: &[u8]| parse(opcode, body).err() == Some(Malformed);
        let name = b"\x07\0\0\0timegap";
        assert!(refused(op::METADATA, &[&name[..], &u32::MAX.to_le_bytes()].concat()));
        assert!(refused(op::METADATA, &u32::MAX.to_le_bytes()));
        let mut chunk_body = vec![0; 8 + 8 + 8 + 4];
        chunk_body.extend(0_u32.to_le_bytes());
        chunk_body.extend(u64::MAX.to_le_bytes());
        assert!(refused(op::CHUNK, &chunk_body));
    }

    #[test]
    fn short_bodies_are_errors_or_nothing() {
        for opcode in 0..=u8::MAX {
            for length in 0..40 {
                let _ = parse(opcode, &vec![0xff; length]);
                let _ = parse(opcode, &vec![0; length]);
            }
        }
    }
}
