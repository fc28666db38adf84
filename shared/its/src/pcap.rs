//! Captures: frames in the classic pcap format behind an Ethernet header, for Wireshark.
//!
//! Format: IETF draft-ietf-opsawg-pcap; microseconds, big or little endian as its magic number says. Here:
//! little endian, link type 1 (Ethernet), EtherType 0x8947.

use crate::geonetworking::ETHER_TYPE;
use std::io::{self, Write};

const MAGIC_MICROSECONDS: u32 = 0xa1b2_c3d4;
const LINK_TYPE_ETHERNET: u32 = 1;
const SNAP_BYTES: u32 = 65_535;
const ETHERNET_BYTES: usize = 14;
/// Bit 1 of the first octet: a locally administered address.
const LOCAL: u8 = 0x02;

/// Writes a capture.
///
/// ```
/// use its::pcap::Writer;
///
/// let mut file = Vec::new();
/// let mut writer = Writer::new(&mut file)?;
/// writer.write(1_780_315_170_123_456_000, 501, b"a GeoNetworking packet")?;
/// writer.finish()?;
/// assert_eq!(file[..4], 0xa1b2_c3d4_u32.to_le_bytes());
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Writer<W: Write> {
    into: W,
}

impl<W: Write> Writer<W> {
    /// Begins a capture.
    ///
    /// # Errors
    /// Errors of `into`.
    pub fn new(mut into: W) -> io::Result<Self> {
        into.write_all(&MAGIC_MICROSECONDS.to_le_bytes())?;
        for half in [2_u16, 4] {
            into.write_all(&half.to_le_bytes())?;
        }
        for word in [0, 0, SNAP_BYTES, LINK_TYPE_ETHERNET] {
            into.write_all(&word.to_le_bytes())?;
        }
        Ok(Self { into })
    }

    /// Writes a frame that was on air at `unix_ns`, sent by `station`.
    ///
    /// # Errors
    /// Errors of `into`.
    pub fn write(&mut self, unix_ns: i64, station: u32, frame: &[u8]) -> io::Result<()> {
        let seconds = unix_ns.div_euclid(1_000_000_000) as u32;
        let microseconds = (unix_ns.rem_euclid(1_000_000_000) / 1_000) as u32;
        let bytes = (ETHERNET_BYTES + frame.len()) as u32;
        for word in [seconds, microseconds, bytes, bytes] {
            self.into.write_all(&word.to_le_bytes())?;
        }
        self.into.write_all(&[0xff; 6])?;
        self.into.write_all(&[LOCAL, 0])?;
        self.into.write_all(&station.to_be_bytes())?;
        self.into.write_all(&ETHER_TYPE.to_be_bytes())?;
        self.into.write_all(frame)
    }

    /// Writes buffered bytes.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(mut self) -> io::Result<()> {
        self.into.flush()
    }
}
