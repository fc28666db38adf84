//! The headers around a message: GeoNetworking's single-hop broadcast and BTP-B.
//!
//! Clauses of ETSI EN 302 636-4-1 V1.4.1:
//!
//! ```text
//! basic header     4 B  9.6    version 1 │ next header 1 (common) │ lifetime │ remaining hops 1
//! common header    8 B  9.7    next header 2 (BTP-B) │ type 5.0 (single-hop broadcast) │ traffic class
//!                              │ mobile flag │ payload length │ hop limit 1
//! extended header 28 B  9.8.4  long position vector of the source (9.5.2) │ 4 B media-dependent, 0
//! BTP-B            4 B         destination port │ port info 0 (EN 302 636-5-1, clause 7.3)
//! ```
//!
//! A signed packet has next header 2 in the basic header (9.6.3): [`crate::signed`] takes it out of its envelope.

use crate::DecodeError;
use crate::geodesy::Position;

/// Bytes before the message.
pub const HEADER_BYTES: usize = GEONETWORKING_BYTES + BTP_BYTES;
/// EtherType of GeoNetworking (EN 302 636-4-1, table 4 of its media-dependent parts).
pub const ETHER_TYPE: u16 = 0x8947;

const GEONETWORKING_BYTES: usize = 40;
const BTP_BYTES: usize = 4;
const SINGLE_HOP_BROADCAST: u8 = 0x50;
const BTP_B: u8 = 2;
/// One second: base 1 s, multiplier 1 (9.6.4). A countdown is outdated after that.
const LIFETIME: u8 = 1 << 2 | 1;

/// Type of a station (EN 302 636-4-1, clause 6.3; numbers of ETSI TS 102 894-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StationType {
    PassengerCar,
    HeavyTruck,
    RoadsideUnit,
    /// Any other, 0 to 31.
    Other(u8),
}

impl StationType {
    pub fn value(self) -> u8 {
        match self {
            Self::PassengerCar => 5,
            Self::HeavyTruck => 8,
            Self::RoadsideUnit => 15,
            Self::Other(value) => value & 31,
        }
    }

    pub fn of(value: u8) -> Self {
        match value & 31 {
            5 => Self::PassengerCar,
            8 => Self::HeavyTruck,
            15 => Self::RoadsideUnit,
            other => Self::Other(other),
        }
    }
}

/// Sender of a packet with position and time: the long position vector (9.5.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    pub station_type: StationType,
    /// The 48 bits of the address.
    pub address: u64,
    /// Time of the position, `TimestampIts` modulo 2^32, ms.
    pub timestamp: u32,
    pub position: Position,
    /// True if the position is as accurate as the standard's `itsGnPaiInterval` requires.
    pub accurate: bool,
    /// Speed, 0.01 m/s, -16384 to 16383.
    pub speed: i16,
    /// Heading from north, clockwise, 0.1 degrees, 0 to 3600.
    pub heading: u16,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headers {
    pub source: Source,
    /// Traffic class (9.7.5), 0 to 63: 0 is the most urgent.
    pub traffic_class: u8,
    /// Destination port of BTP-B.
    pub port: u16,
}

impl Headers {
    /// Appends the headers of a payload of `payload_bytes` to `into`.
    pub fn write(&self, payload_bytes: u16, into: &mut Vec<u8>) {
        let source = &self.source;
        // Basic header.
        into.extend([1 << 4 | 1, 0, LIFETIME, 1]);
        // Common header.
        let mobile = source.station_type != StationType::RoadsideUnit;
        into.extend([BTP_B << 4, SINGLE_HOP_BROADCAST, self.traffic_class & 63]);
        into.push(u8::from(mobile) << 7);
        into.extend((payload_bytes + BTP_BYTES as u16).to_be_bytes());
        into.extend([1, 0]);
        // Long position vector: address, time, position, accuracy with speed, heading.
        let station = u64::from(source.station_type.value()) << 58;
        into.extend((station | source.address & 0xffff_ffff_ffff).to_be_bytes());
        into.extend(source.timestamp.to_be_bytes());
        into.extend(source.position.latitude.to_be_bytes());
        into.extend(source.position.longitude.to_be_bytes());
        let speed = source.speed.clamp(-16_384, 16_383) as u16 & 0x7fff;
        into.extend((u16::from(source.accurate) << 15 | speed).to_be_bytes());
        into.extend(source.heading.to_be_bytes());
        into.extend([0; 4]);
        // BTP-B.
        into.extend(self.port.to_be_bytes());
        into.extend([0; 2]);
    }

    /// Reads the headers of a packet and finds its message.
    ///
    /// # Errors
    /// If it is not a single-hop broadcast with BTP-B, or is too short.
    pub fn read(packet: &[u8]) -> Result<(Self, &[u8]), DecodeError> {
        let truncated = |expected| DecodeError::Truncated { expected, found: packet.len() };
        let [version, _, _, _, ..] = *packet else { return Err(truncated(HEADER_BYTES)) };
        match (version >> 4, version & 15) {
            (1, 2) => return Err(DecodeError::Secured),
            (1, 0 | 1) => {}
            (1, next_header) => {
                return Err(DecodeError::OtherHeader { header_type: 0, next_header });
            }
            (version, _) => return Err(DecodeError::Version(version)),
        }
        let Some((header, rest)) = packet.split_at_checked(HEADER_BYTES) else {
            return Err(truncated(HEADER_BYTES));
        };
        let number = |bytes: std::ops::Range<usize>| {
            header[bytes].iter().fold(0_u64, |number, byte| number << 8 | u64::from(*byte))
        };
        let (next_header, header_type) = (header[4] >> 4, header[5]);
        if (next_header, header_type) != (BTP_B, SINGLE_HOP_BROADCAST) {
            return Err(DecodeError::OtherHeader { header_type, next_header });
        }
        let announced = GEONETWORKING_BYTES + number(8..10) as usize;
        let Some(payload) = announced.checked_sub(HEADER_BYTES).and_then(|n| rest.get(..n)) else {
            return Err(truncated(announced.max(HEADER_BYTES)));
        };
        let address = number(12..20);
        let accuracy_and_speed = number(32..34) as u16;
        let source = Source {
            station_type: StationType::of((address >> 58) as u8),
            address: address & 0xffff_ffff_ffff,
            timestamp: number(20..24) as u32,
            position: Position {
                latitude: number(24..28) as i32,
                longitude: number(28..32) as i32,
            },
            accurate: accuracy_and_speed >> 15 == 1,
            // The sign is the highest of 15 bits.
            speed: (accuracy_and_speed << 1) as i16 >> 1,
            heading: number(34..36) as u16,
        };
        let headers = Self {
            source,
            traffic_class: header[6] & 63,
            port: number(GEONETWORKING_BYTES..GEONETWORKING_BYTES + 2) as u16,
        };
        Ok((headers, payload))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn headers() -> impl Strategy<Value = Headers> {
        let station_type = (0..32u8).prop_map(StationType::of);
        let place = (any::<i32>(), any::<i32>());
        let rest = (any::<u32>(), any::<bool>(), -16_384..16_384i16, 0..3601u16);
        (station_type, 0..1u64 << 48, place, rest, 0..64u8, any::<u16>()).prop_map(
            |(station_type, address, place, rest, traffic_class, port)| Headers {
                source: Source {
                    station_type,
                    address,
                    timestamp: rest.0,
                    position: Position { latitude: place.0, longitude: place.1 },
                    accurate: rest.1,
                    speed: rest.2,
                    heading: rest.3,
                },
                traffic_class,
                port,
            },
        )
    }

    proptest! {
        #[test]
        fn headers_come_back(headers in headers(), payload in prop::collection::vec(any::<u8>(), 0..99)) {
            let mut packet = Vec::new();
            headers.write(payload.len() as u16, &mut packet);
            prop_assert_eq!(packet.len(), HEADER_BYTES);
            packet.extend(&payload);
            prop_assert_eq!(Headers::read(&packet), Ok((headers, payload.as_slice())));
            for cut in 0..packet.len() {
                let read = Headers::read(&packet[..cut]);
                prop_assert!(matches!(read, Err(DecodeError::Truncated { .. })), "{:?}", read);
            }
        }
    }

    #[test]
    fn other_packets_are_named() {
        let mut packet = vec![0; HEADER_BYTES];
        assert_eq!(Headers::read(&packet), Err(DecodeError::Version(0)));
        packet[0] = 0x12;
        assert_eq!(Headers::read(&packet), Err(DecodeError::Secured));
        packet[0] = 0x11;
        let other = DecodeError::OtherHeader { header_type: 0, next_header: 0 };
        assert_eq!(Headers::read(&packet), Err(other));
    }
}
