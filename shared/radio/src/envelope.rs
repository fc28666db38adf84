//! The envelope of a live carrier's packets: 40 bytes in network byte order.
//!
//! | bytes | content |
//! | --- | --- |
//! | 0 to 3 | `TGR1` |
//! | 4 to 7 | kind: 1 frame, 2 question, 3 answer |
//! | 8 to 15 | number of the sender |
//! | 16 to 23 | sequence number of a frame, from 1; 0 in the other kinds |
//! | 24 to 31 | the sender's wall clock, ns since the Unix epoch |
//! | 32 to 39 | the wall clock at the sender's run time 0; the smallest number if it has none |
//!
//! A frame follows unchanged. An answer continues with three numbers of 8 bytes: the asking station, the time of its
//! question, and the question's arrival. The time is by the asking clock, the arrival by the answering one.
//!
//! A GeoNetworking packet never begins with `T`: its first four bits are version 1; those of `T` are 5.

use crate::frame::MAX_FRAME;

const MAGIC: [u8; 4] = *b"TGR1";
const HEADER: usize = 40;
const NO_START: i64 = i64::MIN;

/// Most bytes of a packet.
pub(crate) const MAX_PACKET: usize = HEADER + MAX_FRAME;

/// Start of every packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Envelope {
    pub(crate) sender: u64,
    pub(crate) sequence: u64,
    pub(crate) sent_ns: i64,
    pub(crate) start_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content<'a> {
    Frame(&'a [u8]),
    Question,
    Answer { to: u64, asked_ns: i64, heard_ns: i64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packet<'a> {
    /// A packet of timegap.
    Ours(Envelope, Content<'a>),
    /// A frame without the envelope.
    Bare(&'a [u8]),
    /// A packet that only begins like timegap's.
    Malformed,
}

impl Envelope {
    /// Writes the packet into `room` and returns its length; a frame must not be too long.
    pub(crate) fn write(&self, content: Content<'_>, room: &mut [u8; MAX_PACKET]) -> usize {
        let kind: u32 = match content {
            Content::Frame(_) => 1,
            Content::Question => 2,
            Content::Answer { .. } => 3,
        };
        let mut length = 0;
        let mut put = |bytes: &[u8]| {
            room[length..length + bytes.len()].copy_from_slice(bytes);
            length += bytes.len();
        };
        put(&MAGIC);
        put(&kind.to_be_bytes());
        let start_ns = self.start_ns.unwrap_or(NO_START);
        let times = [self.sent_ns, start_ns].map(i64::cast_unsigned);
        [self.sender, self.sequence].into_iter().chain(times).for_each(|w| put(&w.to_be_bytes()));
        match content {
            Content::Frame(bytes) => put(bytes),
            Content::Question => {}
            Content::Answer { to, asked_ns, heard_ns } => {
                put(&to.to_be_bytes());
                [asked_ns, heard_ns].iter().for_each(|time_ns| put(&time_ns.to_be_bytes()));
            }
        }
        length
    }
}

impl<'a> Packet<'a> {
    pub(crate) fn read(bytes: &'a [u8]) -> Self {
        if !bytes.starts_with(&MAGIC) {
            let fits = !bytes.is_empty() && bytes.len() <= MAX_FRAME;
            return if fits { Self::Bare(bytes) } else { Self::Malformed };
        }
        if bytes.len() < HEADER {
            return Self::Malformed;
        }
        let word = |at: usize| {
            let eight = bytes[at..at + 8].try_into().expect("eight bytes");
            u64::from_be_bytes(eight)
        };
        let start_ns = word(32).cast_signed();
        let envelope = Envelope {
            sender: word(8),
            sequence: word(16),
            sent_ns: word(24).cast_signed(),
            start_ns: (start_ns != NO_START).then_some(start_ns),
        };
        let rest = &bytes[HEADER..];
        let kind = u32::from_be_bytes(bytes[4..8].try_into().expect("four bytes"));
        let content = match (kind, rest.len()) {
            (1, 1..=MAX_FRAME) => Content::Frame(rest),
            (2, 0) => Content::Question,
            (3, 24) => Content::Answer {
                to: word(40),
                asked_ns: word(48).cast_signed(),
                heard_ns: word(56).cast_signed(),
            },
            _ => return Self::Malformed,
        };
        Self::Ours(envelope, content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packets_read_back(
            sender: u64, sequence: u64, sent_ns: i64, start_ns in prop::option::of(0..i64::MAX),
            frame in prop::collection::vec(any::<u8>(), 1..=MAX_FRAME),
            to: u64, asked_ns: i64, heard_ns: i64,
        ) {
            let envelope = Envelope { sender, sequence, sent_ns, start_ns };
            let mut room = [0; MAX_PACKET];
            for content in [
                Content::Frame(&frame),
                Content::Question,
                Content::Answer { to, asked_ns, heard_ns },
            ] {
                let length = envelope.write(content, &mut room);
                prop_assert_eq!(Packet::read(&room[..length]), Packet::Ours(envelope, content));
            }
        }

        #[test]
        fn any_bytes_are_read_without_harm(bytes in prop::collection::vec(any::<u8>(), 0..2000), ours: bool) {
            let mut bytes = bytes;
            if ours && bytes.len() >= 4 {
                bytes[..4].copy_from_slice(&MAGIC);
                let short = bytes.len() < HEADER;
                prop_assert!(!short || Packet::read(&bytes) == Packet::Malformed);
            }
            match Packet::read(&bytes) {
                Packet::Ours(_, Content::Frame(frame)) | Packet::Bare(frame) => {
                    prop_assert!(!frame.is_empty() && frame.len() <= MAX_FRAME);
                }
                Packet::Ours(..) | Packet::Malformed => {}
            }
        }
    }
}
