//! MCAP records as they stand in a file (<https://mcap.dev/spec>), read with every length checked: a
//! file may come from another program, or from an attacker.
//!
//! ```text
//! magic, record*, magic        record: opcode u8, length u64, body
//! chunk body:   start u64, end u64, unpacked bytes u64, checksum u32, compression, records
//! message body: channel u16, sequence u32, log time u64, publish time u64, payload
//! ```
//!
//! All numbers are little-endian; a text has its length, u32, before it. Nothing here allocates what
//! a length in the file asks for.

use std::collections::BTreeMap;

/// What a file begins and ends with.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes of a record before its body: opcode and length.
pub(crate) const HEAD: usize = 9;
/// Bytes of a message's body before its payload.
pub(crate) const MESSAGE_HEAD: usize = 22;

/// Kinds of record that are read; all others are passed over.
pub(crate) mod opcode {
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const STATISTICS: u8 = 0x0B;
    pub(crate) const METADATA: u8 = 0x0C;
    pub(crate) const DATA_END: u8 = 0x0F;
}

/// A body is shorter than what it says it holds, or holds no text where one belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Malformed;

/// Reads one field after another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn bytes(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (now, rest) = self.0.split_at_checked(count).ok_or(Malformed)?;
        self.0 = rest;
        Ok(now)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        Ok(self.bytes(N)?.try_into().expect("as many as were asked for"))
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes with their length, 32 bits, before them.
    fn block(&mut self) -> Result<&'a [u8], Malformed> {
        let length = self.u32()?;
        self.bytes(usize::try_from(length).map_err(|_| Malformed)?)
    }

    pub(crate) fn text(&mut self) -> Result<&'a str, Malformed> {
        std::str::from_utf8(self.block()?).map_err(|_| Malformed)
    }

    fn texts(&mut self) -> Result<BTreeMap<String, String>, Malformed> {
        let mut fields = Fields(self.block()?);
        let mut map = BTreeMap::new();
        while !fields.0.is_empty() {
            map.insert(fields.text()?.to_owned(), fields.text()?.to_owned());
        }
        Ok(map)
    }
}

/// Opcode and length of the body of a record that begins with `head`.
pub(crate) fn head(head: &[u8]) -> Result<(u8, u64), Malformed> {
    let mut fields = Fields(head);
    let [opcode] = fields.array()?;
    Ok((opcode, fields.u64()?))
}

/// A message type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Schema<'a> {
    pub(crate) id: u16,
    pub(crate) name: &'a str,
    pub(crate) encoding: &'a str,
    pub(crate) definition: &'a [u8],
}

pub(crate) fn schema(body: &[u8]) -> Result<Schema<'_>, Malformed> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let name = fields.text()?;
    let encoding = fields.text()?;
    Ok(Schema { id, name, encoding, definition: fields.block()? })
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Channel<'a> {
    pub(crate) id: u16,
    pub(crate) schema: u16,
    pub(crate) topic: &'a str,
    pub(crate) encoding: &'a str,
}

pub(crate) fn channel(body: &[u8]) -> Result<Channel<'_>, Malformed> {
    let mut fields = Fields(body);
    let (id, schema) = (fields.u16()?, fields.u16()?);
    let topic = fields.text()?;
    Ok(Channel { id, schema, topic, encoding: fields.text()? })
}

/// What stands before a message's payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MessageHead {
    pub(crate) channel: u16,
    pub(crate) log_time: u64,
    pub(crate) publish_time: u64,
}

pub(crate) fn message(body: &[u8]) -> Result<(MessageHead, &[u8]), Malformed> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.u32()?;
    let head = MessageHead { channel, log_time: fields.u64()?, publish_time: fields.u64()? };
    Ok((head, fields.0))
}

/// A chunk, still packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Chunk<'a> {
    /// Length of its records, bytes.
    pub(crate) unpacked: u64,
    /// CRC-32 of its records; 0 if there is none.
    pub(crate) checksum: u32,
    pub(crate) compression: &'a str,
    pub(crate) packed: &'a [u8],
}

pub(crate) fn chunk(body: &[u8]) -> Result<Chunk<'_>, Malformed> {
    let mut fields = Fields(body);
    let (_start, _end) = (fields.u64()?, fields.u64()?);
    let (unpacked, checksum) = (fields.u64()?, fields.u32()?);
    let compression = fields.text()?;
    let length = usize::try_from(fields.u64()?).map_err(|_| Malformed)?;
    Ok(Chunk { unpacked, checksum, compression, packed: fields.bytes(length)? })
}

/// A named map.
pub(crate) fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), Malformed> {
    let mut fields = Fields(body);
    Ok((fields.text()?, fields.texts()?))
}

/// What a whole file says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Statistics {
    pub(crate) messages: u64,
    /// Earliest and latest log time.
    pub(crate) start: u64,
    pub(crate) end: u64,
    /// Messages by channel.
    pub(crate) channels: BTreeMap<u16, u64>,
}

pub(crate) fn statistics(body: &[u8]) -> Result<Statistics, Malformed> {
    let mut fields = Fields(body);
    let messages = fields.u64()?;
    fields.bytes(2 + 4 + 4 + 4 + 4)?;
    let (start, end) = (fields.u64()?, fields.u64()?);
    let mut counts = Fields(fields.block()?);
    let mut channels = BTreeMap::new();
    while !counts.0.is_empty() {
        channels.insert(counts.u16()?, counts.u64()?);
    }
    Ok(Statistics { messages, start, end, channels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_end_is_refused_before_anything_is_allocated() {
        let name = b"\x07\0\0\0timegap";
        let huge = [&name[..], &u32::MAX.to_le_bytes()].concat();
        assert_eq!(metadata(&huge), Err(Malformed));
        assert_eq!(metadata(&u32::MAX.to_le_bytes()), Err(Malformed));
        let mut chunk_body = vec![0; 8 + 8 + 8 + 4];
        chunk_body.extend(0_u32.to_le_bytes());
        chunk_body.extend(u64::MAX.to_le_bytes());
        assert_eq!(chunk(&chunk_body), Err(Malformed));
    }

    #[test]
    fn a_map_is_read_pair_by_pair() {
        let pair = |key: &str, value: &str| {
            [key, value].map(|text| [&[text.len() as u8, 0, 0, 0], text.as_bytes()].concat())
        };
        let pairs = [pair("a", "1"), pair("b", "")].concat().concat();
        let mut body = b"\x01\0\0\0m".to_vec();
        body.extend((pairs.len() as u32).to_le_bytes());
        body.extend(&pairs);
        let (name, map) = metadata(&body).expect("well formed");
        let expected = [("a", "1"), ("b", "")].map(|(k, v)| (k.to_owned(), v.to_owned()));
        assert_eq!((name, map), ("m", expected.into()));
    }
}
