//! Signed frames: the envelope of ETSI TS 103 097 V2.1.1, which is `signedData` of IEEE 1609.2.
//!
//! ```text
//! basic header 4 B, next header 2 │ version 3 │ 81: signedData │ hash │ payload: a packet from its common header on
//!                                  │ psid, generation time, ... │ signer: digest or certificate │ signature
//! ```
//!
//! The bytes are octets of the canonical encoding rules (COER, ITU-T X.696). [`open`] takes the packet out of its
//! envelope. It does **not** verify the signature: that needs the certificates of an authority. So a signed frame proves
//! no more than one without a signature, and the signer is who the envelope names.

use crate::{DecodeError, Frame};
use sha2::{Digest, Sha256};

/// Bytes of the basic header.
const BASIC_BYTES: usize = 4;
/// `protocolVersion`.
const VERSION: u8 = 3;
/// Seconds from the Unix epoch to 2004-01-01, from which the generation time counts.
const EPOCH_S: i64 = 1_072_915_200;
/// Leap seconds between 2004 and now: the generation time counts them.
const LEAP_SECONDS: i64 = 5;
/// Bytes of an ECDSA signature over 256 bits: its kind, and the two numbers, the first with a kind of its own.
const SIGNATURE_BYTES: usize = 66;

/// Sender by whom the envelope says that it is signed. Nothing verifies this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Signer {
    /// The last eight bytes of the SHA-256 of its certificate.
    Digest([u8; 8]),
    /// A chain of certificates, or one of a kind whose end is not found.
    Certificates,
    /// The sender itself.
    Own,
}

impl std::fmt::Display for Signer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Digest(digest) => digest.iter().try_for_each(|byte| write!(f, "{byte:02x}")),
            Self::Certificates => f.write_str("certificates"),
            Self::Own => f.write_str("self"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    pub signer: Signer,
    /// Time of the signature, ms since the Unix epoch, UTC; `None` if the envelope has none.
    pub generated_ms: Option<i64>,
    /// Service: 36 CAM, 137 SPATEM, 138 MAPEM.
    pub psid: u64,
}

/// Reads a frame, out of its envelope if it has one.
///
/// # Errors
/// [`DecodeError`] describes the fault.
pub fn decode(bytes: &[u8]) -> Result<(Frame, Option<Envelope>), DecodeError> {
    match open(bytes)? {
        Some((envelope, packet)) => Ok((Frame::decode(&packet)?, Some(envelope))),
        None => Ok((Frame::decode(bytes)?, None)),
    }
}

/// Takes a packet out of its envelope; `None` if it has none.
///
/// # Errors
/// [`DecodeError::Envelope`] if the envelope is broken, or encrypted.
pub fn open(bytes: &[u8]) -> Result<Option<(Envelope, Vec<u8>)>, DecodeError> {
    if bytes.len() > crate::MAX_FRAME_BYTES {
        return Err(DecodeError::TooLong(bytes.len()));
    }
    let Some((basic, rest)) = bytes.split_at_checked(BASIC_BYTES) else { return Ok(None) };
    if basic[0] != 1 << 4 | 2 {
        return Ok(None);
    }
    let mut octets = Octets { rest, place: "its start" };
    let (envelope, payload) = octets.signed().ok_or(DecodeError::Envelope(octets.place))?;
    let mut packet = Vec::with_capacity(BASIC_BYTES + payload.len());
    packet.extend([1 << 4 | 1, basic[1], basic[2], basic[3]]);
    packet.extend(payload);
    Ok(Some((envelope, packet)))
}

/// Octets that are left, and the field that is being read.
struct Octets<'a> {
    rest: &'a [u8],
    place: &'static str,
}

impl<'a> Octets<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn one(&mut self) -> Option<u8> {
        self.take(1).map(|byte| byte[0])
    }

    fn expect(&mut self, octets: &[u8]) -> Option<()> {
        (self.take(octets.len())? == octets).then_some(())
    }

    /// A number of as many bytes as are asked for, at most eight.
    fn number(&mut self, count: usize) -> Option<u64> {
        let bytes = self.take(count).filter(|_| count <= 8)?;
        Some(bytes.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    /// A length, in one byte or behind a count of bytes.
    fn length(&mut self) -> Option<usize> {
        match self.one()? {
            short @ ..0x80 => Some(short.into()),
            long => self.number(usize::from(long & 0x7f)).and_then(|n| usize::try_from(n).ok()),
        }
    }

    /// `Ieee1609Dot2Data` with `signedData`.
    fn signed(&mut self) -> Option<(Envelope, &'a [u8])> {
        self.place = "its version or kind: 3 with signedData was expected";
        self.expect(&[VERSION, 0x81])?;
        self.place = "the hash algorithm";
        self.one()?;
        self.place = "the payload: data inside it was expected";
        // Data is there, and a hash of data elsewhere may be.
        let fields = self.one().filter(|fields| fields & 0xdf == 0x40)?;
        self.expect(&[VERSION, 0x80])?;
        let length = self.length()?;
        let payload = self.take(length)?;
        if fields & 0x20 != 0 {
            self.expect(&[0x80])?;
            self.take(32)?;
        }
        self.place = "the header: a service and a time were expected";
        let (psid, generated_ms) = self.header()?;
        self.place = "the signer";
        Some((Envelope { signer: self.signer()?, generated_ms, psid }, payload))
    }

    /// `HeaderInfo`, up to what stands before the signer.
    fn header(&mut self) -> Option<(u64, Option<i64>)> {
        let fields = self.one()?;
        let has = |place: u8| fields & 0x80 >> place != 0;
        let length = self.length()?;
        let psid = self.number(length)?;
        let generated_ms = match has(1) {
            true => Some(utc_ms(self.number(8)?)?),
            false => None,
        };
        // Expiry time, generation location, request for a certificate.
        for (_, octets) in [(2, 8), (3, 10), (4, 3)].into_iter().filter(|(place, _)| has(*place)) {
            self.take(octets)?;
        }
        if has(5) || has(6) {
            // A missing list of revoked certificates, or a key: in no message to all.
            return None;
        }
        if has(0) {
            self.additions()?;
        }
        Some((psid, generated_ms))
    }

    /// Additions behind an extension bit: a map of the present ones, then each with its length.
    fn additions(&mut self) -> Option<()> {
        let length = self.length()?;
        let map = self.take(length)?;
        let (unused, bits) = map.split_first()?;
        let count: u32 = bits.iter().map(|byte| byte.count_ones()).sum();
        for _ in 0..count.min(8 * bits.len() as u32 - u32::from(*unused).min(7)) {
            let length = self.length()?;
            self.take(length)?;
        }
        Some(())
    }

    fn signer(&mut self) -> Option<Signer> {
        match self.one()? {
            0x80 => Some(Signer::Digest(self.take(8)?.try_into().ok()?)),
            0x81 => {
                let bytes = self.length()?;
                let count = self.number(bytes)?;
                // The certificate ends where the signature begins.
                let certificate = self.rest.len().checked_sub(SIGNATURE_BYTES)?;
                let (certificate, signature) = self.rest.split_at(certificate);
                let is_whole = signature[0] == 0x80 && matches!(signature[1], 0x80..=0x84);
                if count != 1 || !is_whole {
                    return Some(Signer::Certificates);
                }
                let hash = Sha256::digest(certificate);
                Some(Signer::Digest(hash[24..].try_into().ok()?))
            }
            0x82 => Some(Signer::Own),
            _ => None,
        }
    }
}

/// UTC of a generation time, which is µs of atomic time since 2004, in ms since the Unix epoch.
fn utc_ms(microseconds: u64) -> Option<i64> {
    let ms = i64::try_from(microseconds / 1000).ok()?;
    ms.checked_add((EPOCH_S - LEAP_SECONDS) * 1000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A packet in an envelope, as stations in use send it: a time, and a digest as signer.
    fn sealed(packet: &[u8], psid: u8, signer: &[u8]) -> Vec<u8> {
        let payload = &packet[4..];
        let mut bytes = vec![0x12, packet[1], packet[2], packet[3], 3, 0x81, 0, 0x40, 3, 0x80];
        match payload.len() {
            short @ ..0x80 => bytes.push(short as u8),
            long => bytes.extend([0x82, (long >> 8) as u8, long as u8]),
        }
        bytes.extend(payload);
        bytes.extend([0x40, 1, psid]);
        bytes.extend(((1_780_315_170_000 - (EPOCH_S - 5) * 1000) as u64 * 1000).to_be_bytes());
        bytes.extend(signer);
        bytes.extend([0x80, 0x80]);
        bytes.extend([7; 64]);
        bytes
    }

    const PACKET: [u8; 60] = {
        let mut packet = [9; 60];
        packet[0] = 0x11;
        packet
    };
    const DIGEST: [u8; 9] = [0x80, 1, 2, 3, 4, 5, 6, 7, 0xfe];

    #[test]
    fn a_packet_comes_out_of_its_envelope_with_signer_and_time() {
        let (envelope, packet) =
            open(&sealed(&PACKET, 137, &DIGEST)).expect("whole").expect("signed");
        assert_eq!(packet, PACKET);
        assert_eq!(envelope.signer.to_string(), "01020304050607fe");
        assert_eq!((envelope.generated_ms, envelope.psid), (Some(1_780_315_170_000), 137));
        let long = [&PACKET[..], &[5; 400]].concat();
        assert_eq!(open(&sealed(&long, 36, &DIGEST)).expect("whole").expect("signed").1, long);
        assert_eq!(open(&PACKET), Ok(None));
    }

    #[test]
    fn a_certificate_is_named_by_its_digest() {
        let signer = [&[0x81, 1, 1][..], &[0x80, 3, 0, 0x80, 1, 2, 3]].concat();
        let (envelope, _) = open(&sealed(&PACKET, 36, &signer)).expect("whole").expect("signed");
        let hash = Sha256::digest(&signer[3..]);
        assert_eq!(envelope.signer, Signer::Digest(hash[24..].try_into().expect("eight")));
        let two = [&[0x81, 1, 2][..], &[0; 90]].concat();
        let (envelope, _) = open(&sealed(&PACKET, 36, &two)).expect("whole").expect("signed");
        assert_eq!(envelope.signer, Signer::Certificates);
    }

    #[test]
    fn broken_and_encrypted_envelopes_name_the_field() {
        let whole = sealed(&PACKET, 137, &DIGEST);
        for cut in 4..whole.len() - 66 {
            assert!(matches!(open(&whole[..cut]), Err(DecodeError::Envelope(_))), "{cut}");
        }
        let mut encrypted = whole;
        encrypted[5] = 0x82;
        let said = open(&encrypted).expect_err("encrypted").to_string();
        assert!(said.contains("signedData was expected"), "{said}");
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = open(&[&[0x12, 0, 0, 1, 3, 0x81, 0, 0x40, 3, 0x80][..], &bytes].concat());
            let _ = open(&bytes);
        }
    }
}
