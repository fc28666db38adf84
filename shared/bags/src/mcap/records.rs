//! MCAP records as they stand in a file (<https://mcap.dev/spec>). Every length is checked, as a
//! file may come from another program or an attacker.
//!
//! ```text
//! magic, record*, magic        record: opcode u8, length u64, body
//! chunk body:   start u64, end u64, unpacked bytes u64, checksum u32, compression, records
//! message body: channel u16, sequence u32, log time u64, publish time u64, payload
//! ```
//!
//! All numbers are little-endian; a text has its length, u32, before it. Nothing here allocates what
//! a length in the file asks for. Every reader fails with [`Malformed`] where the bytes end too early.

use std::collections::BTreeMap;

/// First and last bytes of a file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes of a record before its body: opcode and length.
pub const HEAD: usize = 9;
/// Bytes of a message's body before its payload.
pub const MESSAGE_HEAD: usize = 22;

/// Kinds of record that are read; all others are passed over.
pub mod opcode {
    /// End of the file, with the place of its summary.
    pub const FOOTER: u8 = 0x02;
    /// A message type.
    pub const SCHEMA: u8 = 0x03;
    /// A topic.
    pub const CHANNEL: u8 = 0x04;
    /// A message.
    pub const MESSAGE: u8 = 0x05;
    /// Packed records.
    pub const CHUNK: u8 = 0x06;
    /// Counts of the whole file.
    pub const STATISTICS: u8 = 0x0B;
    /// A named map.
    pub const METADATA: u8 = 0x0C;
    /// End of the messages.
    pub const DATA_END: u8 = 0x0F;
}

/// A body is shorter than its stated content, or has no text where one belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// Reads one field after another.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    /// Takes `count` bytes.
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (now, rest) = self.0.split_at_checked(count).ok_or(Malformed)?;
        self.0 = rest;
        Ok(now)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        Ok(self.bytes(N)?.try_into().expect("as many as were asked for"))
    }

    /// Takes a number of 16 bits.
    pub fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    /// Takes a number of 32 bits.
    pub fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    /// Takes a number of 64 bits.
    pub fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes with their length, 32 bits, before them.
    fn block(&mut self) -> Result<&'a [u8], Malformed> {
        let length = self.u32()?;
        self.bytes(usize::try_from(length).map_err(|_| Malformed)?)
    }

    /// Takes a text with its length before it.
    pub fn text(&mut self) -> Result<&'a str, Malformed> {
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

/// Reads opcode and length of the body of a record that begins with `head`.
pub fn head(head: &[u8]) -> Result<(u8, u64), Malformed> {
    let mut fields = Fields(head);
    let [opcode] = fields.array()?;
    Ok((opcode, fields.u64()?))
}

/// Takes the record at the start of `bytes` apart: opcode and body, and the bytes behind it.
pub fn record(bytes: &[u8]) -> Result<(u8, &[u8], &[u8]), Malformed> {
    let (opcode, length) = head(bytes)?;
    let mut fields = Fields(&bytes[HEAD..]);
    let body = fields.bytes(usize::try_from(length).map_err(|_| Malformed)?)?;
    Ok((opcode, body, fields.0))
}

/// A message type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema<'a> {
    /// Number in the file.
    pub id: u16,
    pub name: &'a str,
    /// Language of the definition.
    pub encoding: &'a str,
    pub definition: &'a [u8],
}

/// Reads the body of a schema.
pub fn schema(body: &[u8]) -> Result<Schema<'_>, Malformed> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let name = fields.text()?;
    let encoding = fields.text()?;
    Ok(Schema { id, name, encoding, definition: fields.block()? })
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel<'a> {
    /// Number in the file.
    pub id: u16,
    /// Number of the type; 0 if there is none.
    pub schema: u16,
    pub topic: &'a str,
    pub encoding: &'a str,
}

/// Reads the body of a channel.
pub fn channel(body: &[u8]) -> Result<Channel<'_>, Malformed> {
    let mut fields = Fields(body);
    let (id, schema) = (fields.u16()?, fields.u16()?);
    let topic = fields.text()?;
    Ok(Channel { id, schema, topic, encoding: fields.text()? })
}

/// Header of a message's payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageHead {
    pub channel: u16,
    /// Time of recording, ns since 1970.
    pub log_time: u64,
    /// Time of sending, ns since 1970.
    pub publish_time: u64,
}

/// Reads the body of a message: its head and its payload.
pub fn message(body: &[u8]) -> Result<(MessageHead, &[u8]), Malformed> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.u32()?;
    let head = MessageHead { channel, log_time: fields.u64()?, publish_time: fields.u64()? };
    Ok((head, fields.0))
}

/// A chunk, still packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk<'a> {
    /// Length of its records, bytes.
    pub unpacked: u64,
    /// CRC-32 of its records; 0 if there is none.
    pub checksum: u32,
    /// Name of the compression; empty if there is none.
    pub compression: &'a str,
    pub packed: &'a [u8],
}

/// Reads the body of a chunk.
pub fn chunk(body: &[u8]) -> Result<Chunk<'_>, Malformed> {
    let mut fields = Fields(body);
    let (_start, _end) = (fields.u64()?, fields.u64()?);
    let (unpacked, checksum) = (fields.u64()?, fields.u32()?);
    let compression = fields.text()?;
    let length = usize::try_from(fields.u64()?).map_err(|_| Malformed)?;
    Ok(Chunk { unpacked, checksum, compression, packed: fields.bytes(length)? })
}

/// A named map.
pub fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), Malformed> {
    let mut fields = Fields(body);
    Ok((fields.text()?, fields.texts()?))
}

/// Description of a whole file by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statistics {
    pub messages: u64,
    /// Earliest log time, ns since 1970.
    pub start: u64,
    /// Latest log time, ns since 1970.
    pub end: u64,
    pub channels: BTreeMap<u16, u64>,
}

/// Reads the body of the statistics.
pub fn statistics(body: &[u8]) -> Result<Statistics, Malformed> {
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
