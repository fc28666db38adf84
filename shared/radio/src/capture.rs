//! A capture, pcap or pcapng, as a carrier. A frame is due when the run time equals its distance from the
//! first frame.
//!
//! In Ethernet, Linux's cooked link and IEEE 802.11 (with or without radiotap), frames with the EtherType of
//! GeoNetworking count (0x8947, also after a VLAN tag). Others are skipped. Packets of `USER0` to `USER15` are frames
//! without a link header.

use crate::clock::ClockDifference;
use crate::frame::{Frame, MAX_FRAME};
use pcap_parser::pcapng::Block;
use pcap_parser::{Linktype, PcapBlockOwned, PcapError, create_reader};
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::Path;

/// Largest size of a capture, bytes: it is held in memory.
const MAX_BYTES: u64 = 256 << 20;
/// Largest size of one block of it, bytes.
const MAX_BLOCK: usize = 1 << 20;
const ETHERTYPE_GEONETWORKING: u16 = 0x8947;
const ETHERTYPE_VLAN: u16 = 0x8100;
const FIRST_USER: i32 = 147;
const LAST_USER: i32 = 162;

/// Reason why a capture cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    #[error("{0}")]
    Read(#[source] io::Error),
    /// The file is larger than the memory for it.
    #[error("{0} bytes are too many, expected at most {max}", max = MAX_BYTES)]
    TooLarge(u64),
    #[error("is not a capture, expected pcap or pcapng")]
    NoCapture,
    #[error(
        "packet {packet}: its link type is {link_type}, expected 1 (Ethernet), 105 (IEEE 802.11), 113 (Linux \
         cooked), 127 (radiotap) or 147 to 162 (USER, the packet is the frame)"
    )]
    LinkType {
        /// Number of the packet, from 1.
        packet: u64,
        link_type: i32,
    },
    #[error("cannot be read after packet {packets}: {reason}")]
    Block {
        /// Number of packets before it.
        packets: u64,
        reason: String,
    },
    /// Packets of a pcapng capture are in blocks without a stamp.
    #[error(
        "{unstamped} of {packets} packets are simple packet blocks, which have no time stamp, \
         expected enhanced packet blocks"
    )]
    Unstamped {
        /// Number of packets without a stamp.
        unstamped: u64,
        packets: u64,
    },
    #[error(
        "none of {0} packets is a GeoNetworking frame (EtherType 0x8947, at most {max} bytes)",
        max = MAX_FRAME
    )]
    NoFrames(u64),
}

/// A capture for playback.
///
/// ```
/// use radio::Capture;
///
/// // A pcap header with link type 147 (`USER0`), and a packet of three bytes.
/// let mut file = 0xa1b2_c3d4_u32.to_le_bytes().to_vec();
/// file.extend([2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0, 0, 147, 0, 0, 0]);
/// file.extend([1_u32, 0, 3, 3].map(u32::to_le_bytes).concat());
/// file.extend(b"abc");
/// let mut capture = Capture::read(file.as_slice())?;
/// let frame = capture.receive(0).expect("the first frame is due at once");
/// assert_eq!(frame.bytes(), b"abc");
/// # Ok::<(), radio::CaptureError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Capture {
    /// Stamps, ns, and places of the frames among the bytes.
    frames: Vec<(i64, Range<usize>)>,
    bytes: Vec<u8>,
    played: usize,
    /// Number of packets that are not frames: another EtherType, too long, or captured incompletely.
    pub passed_over: u64,
    /// True if the file ends inside a packet.
    pub is_truncated: bool,
}

/// An interface of a capture: link type and unit of its stamps.
#[derive(Clone, Copy, Debug)]
struct Interface {
    link: Linktype,
    per_second: u64,
    offset_s: i64,
}

impl Capture {
    /// Reads a capture. A truncated one ends before its incomplete packet ([`Capture::is_truncated`]).
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        let file = File::open(path).map_err(CaptureError::Read)?;
        let about = file.metadata().map_err(CaptureError::Read)?;
        if about.is_dir() {
            return Err(CaptureError::Read(io::ErrorKind::IsADirectory.into()));
        }
        if about.len() > MAX_BYTES {
            return Err(CaptureError::TooLarge(about.len()));
        }
        // A pipe has no size; the same bound applies while reading.
        Self::read(io::Read::take(file, MAX_BYTES))
    }

    pub fn read(source: impl io::Read + Send) -> Result<Self, CaptureError> {
        let mut reader = create_reader(MAX_BLOCK, source).map_err(|_| CaptureError::NoCapture)?;
        let mut this = Self::default();
        let mut interfaces: Vec<Interface> = Vec::new();
        let (mut packets, mut unstamped) = (0, 0);
        loop {
            let refill = match reader.next() {
                Ok((length, block)) => {
                    match block {
                        PcapBlockOwned::NG(Block::SimplePacket(_)) => {
                            (packets, unstamped) = (packets + 1, unstamped + 1);
                        }
                        block => this.block(block, &mut interfaces, &mut packets)?,
                    }
                    reader.consume(length);
                    continue;
                }
                Err(PcapError::Eof) => break,
                Err(PcapError::UnexpectedEof) => false,
                Err(PcapError::Incomplete(_)) => !reader.reader_exhausted(),
                Err(PcapError::NomError(_, kind) | PcapError::OwnedNomError(_, kind)) => {
                    return Err(fault(packets, format!("a malformed block ({kind:?})")));
                }
                Err(PcapError::BufferTooSmall) => {
                    return Err(fault(packets, format!("a block of more than {MAX_BLOCK} bytes")));
                }
                Err(other) => return Err(fault(packets, other.to_string())),
            };
            if !refill {
                this.is_truncated = true;
                break;
            }
            reader.refill().map_err(|_| CaptureError::Read(io::ErrorKind::Other.into()))?;
        }
        if unstamped > 0 {
            return Err(CaptureError::Unstamped { unstamped, packets });
        }
        if this.frames.is_empty() {
            return Err(CaptureError::NoFrames(packets));
        }
        // Packets of several interfaces need not be in order.
        this.frames.sort_by_key(|(stamp_ns, _)| *stamp_ns);
        Ok(this)
    }

    fn block(
        &mut self,
        block: PcapBlockOwned<'_>,
        interfaces: &mut Vec<Interface>,
        packets: &mut u64,
    ) -> Result<(), CaptureError> {
        match block {
            PcapBlockOwned::LegacyHeader(header) => {
                let per_second =
                    if header.is_nanosecond_precision() { 1_000_000_000 } else { 1_000_000 };
                interfaces.push(Interface { link: header.network, per_second, offset_s: 0 });
                Ok(())
            }
            PcapBlockOwned::Legacy(packet) => {
                *packets += 1;
                let Some(interface) = interfaces.first() else { return Ok(()) };
                let stamp_ns = i64::from(packet.ts_sec) * 1_000_000_000
                    + i64::from(packet.ts_usec)
                        * (1_000_000_000 / interface.per_second).cast_signed();
                let whole = packet.caplen == packet.origlen;
                self.packet(interface.link, stamp_ns, packet.data, whole, *packets)
            }
            PcapBlockOwned::NG(Block::SectionHeader(_)) => {
                interfaces.clear();
                Ok(())
            }
            PcapBlockOwned::NG(Block::InterfaceDescription(interface)) => {
                let per_second = interface.ts_resolution().filter(|per_second| *per_second > 0);
                let reason = "an interface with a resolution of stamps that is not known";
                let per_second = per_second.ok_or_else(|| fault(*packets, reason))?;
                let (link, offset_s) = (interface.linktype, interface.ts_offset());
                interfaces.push(Interface { link, per_second, offset_s });
                Ok(())
            }
            PcapBlockOwned::NG(Block::EnhancedPacket(packet)) => {
                *packets += 1;
                let interface = usize::try_from(packet.if_id).ok().and_then(|i| interfaces.get(i));
                let reason = "a packet of an interface that is not described";
                let interface = interface.ok_or_else(|| fault(*packets, reason))?;
                let stamp_ns = interface.stamp_ns(packet.ts_high, packet.ts_low);
                let length = usize::try_from(packet.caplen).unwrap_or(usize::MAX);
                let whole = packet.caplen == packet.origlen;
                let data = packet.data.get(..length).unwrap_or(packet.data);
                self.packet(interface.link, stamp_ns, data, whole, *packets)
            }
            // Statistics, comments.
            PcapBlockOwned::NG(_) => Ok(()),
        }
    }

    fn packet(
        &mut self,
        link: Linktype,
        stamp_ns: i64,
        data: &[u8],
        whole: bool,
        packet: u64,
    ) -> Result<(), CaptureError> {
        let frame = match link.0 {
            1 => after_ether_type(data, 12),
            105 => in_wireless(data),
            113 => after_ether_type(data, 14),
            127 => behind_radiotap(data).and_then(in_wireless),
            FIRST_USER..=LAST_USER => Some(data),
            link_type => return Err(CaptureError::LinkType { packet, link_type }),
        };
        match frame {
            Some(frame) if whole && (1..=MAX_FRAME).contains(&frame.len()) => {
                let from = self.bytes.len();
                self.bytes.extend_from_slice(frame);
                self.frames.push((stamp_ns, from..self.bytes.len()));
            }
            _ => self.passed_over += 1,
        }
        Ok(())
    }

    /// The next frame that is due by run time `now_ns`, ns.
    pub fn receive(&mut self, now_ns: i64) -> Option<Frame> {
        let (stamp_ns, place) = self.frames.get(self.played).cloned()?;
        if stamp_ns > self.wall_clock_ns(now_ns) {
            return None;
        }
        self.played += 1;
        let frame = Frame::new(&self.bytes[place], stamp_ns).expect("a longer one is skipped");
        let clock = Some(ClockDifference { offset_ns: 0, uncertainty_ns: 0 });
        Some(Frame { sent_ns: Some(stamp_ns), clock, ..frame })
    }

    /// The capture's clock at run time `now_ns`, ns since the Unix epoch.
    pub fn wall_clock_ns(&self, now_ns: i64) -> i64 {
        self.frames.first().map_or(0, |first| first.0).saturating_add(now_ns)
    }

    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Time from its first to its last frame, ns.
    pub fn duration_ns(&self) -> i64 {
        let ends = self.frames.first().zip(self.frames.last());
        ends.map_or(0, |(first, last)| last.0 - first.0)
    }

    /// Number of frames received so far.
    pub fn played(&self) -> u64 {
        self.played as u64
    }
}

/// The error of a block behind some packets.
fn fault(packets: u64, reason: impl Into<String>) -> CaptureError {
    CaptureError::Block { packets, reason: reason.into() }
}

impl Interface {
    fn stamp_ns(&self, high: u32, low: u32) -> i64 {
        let ticks = u128::from(high) << 32 | u128::from(low);
        let ns = ticks * 1_000_000_000 / u128::from(self.per_second);
        let offset_ns = self.offset_s.saturating_mul(1_000_000_000);
        i64::try_from(ns).unwrap_or(i64::MAX).saturating_add(offset_ns)
    }
}

/// The GeoNetworking packet in a frame whose EtherType stands at `at`, if it holds one.
fn after_ether_type(frame: &[u8], mut at: usize) -> Option<&[u8]> {
    let word = |at: usize| Some(u16::from_be_bytes([*frame.get(at)?, *frame.get(at + 1)?]));
    if word(at)? == ETHERTYPE_VLAN {
        at += 4;
    }
    (word(at)? == ETHERTYPE_GEONETWORKING).then(|| &frame[at + 2..])
}

/// The GeoNetworking packet in a data frame of IEEE 802.11 that is not encrypted. Its EtherType stands behind LLC and
/// SNAP, or outside the context of a BSS (5.1.4 of the standard of 2020) behind the header at once.
fn in_wireless(frame: &[u8]) -> Option<&[u8]> {
    let (kind, flags) = (*frame.first()?, *frame.get(1)?);
    let (is_data, is_empty, has_quality) =
        (kind & 0x0c == 0x08, kind & 0x40 != 0, kind & 0x80 != 0);
    if !is_data || is_empty || flags & 0x40 != 0 {
        return None;
    }
    let fourth_address = if flags & 3 == 3 { 6 } else { 0 };
    // With the quality of service comes the field of high throughput, if the order bit is set.
    let quality = if has_quality { 2 + if flags & 0x80 != 0 { 4 } else { 0 } } else { 0 };
    let at = 24 + fourth_address + quality;
    let has_snap = frame.get(at..at + 6) == Some(&[0xaa, 0xaa, 3, 0, 0, 0]);
    after_ether_type(frame, if has_snap { at + 6 } else { at })
}

/// The frame behind a header of radiotap, without its check sequence (`radiotap.org/fields`).
fn behind_radiotap(packet: &[u8]) -> Option<&[u8]> {
    let word = |at: usize| Some(u32::from_le_bytes(packet.get(at..at + 4)?.try_into().ok()?));
    let length = usize::try_from(word(0)? >> 16).ok()?;
    let present = word(4)?;
    let mut at = 8;
    while word(at - 4)? >> 31 == 1 {
        at += 4;
    }
    // The flags stand behind the timer's 8 bytes.
    if present & 1 != 0 {
        at = at.next_multiple_of(8) + 8;
    }
    let has_check = present & 2 != 0 && packet.get(at)? & 0x10 != 0;
    packet.get(length..packet.len().checked_sub(if has_check { 4 } else { 0 })?)
}
