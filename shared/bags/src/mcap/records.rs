//! MCAP records as they stand in a file (<https://mcap.dev/spec>). Every length is checked, as a
//! file may come from another program or an attacker.
//!
//! ```text
//! magic, record*, magic        record: opcode u8, length u64, body
//! ```
//!
//! All numbers are little-endian. The library `mcap` reads the bodies. Nothing allocates what a length in the file asks
//! for.

use ::mcap::records::{Record, op};

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
