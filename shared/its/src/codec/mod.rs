//! Between this crate's messages and those that are generated from the standards' ASN.1.

pub(crate) mod cam;
pub(crate) mod mapem;
pub(crate) mod spatem;

use crate::{DecodeError, EncodeError};
use rasn::types::FixedBitString;

/// Version of the messages that are sent.
const PROTOCOL_VERSION: u8 = 2;

fn to_uper<T: rasn::Encode>(message: &T) -> Result<Vec<u8>, EncodeError> {
    rasn::uper::encode(message).map_err(|e| EncodeError::Range(e.to_string()))
}

fn from_uper<T: rasn::Decode>(payload: &[u8]) -> Result<T, DecodeError> {
    rasn::uper::decode(payload).map_err(|e| DecodeError::Payload(e.kind.to_string()))
}

/// A bit string of the standard whose bit n is bit n of `flags`.
fn bits<const N: usize>(flags: u16) -> FixedBitString<N> {
    let mut bits = FixedBitString::<N>::ZERO;
    for n in 0..N {
        bits.set(n, flags >> n & 1 == 1);
    }
    bits
}

fn flags<const N: usize>(bits: &FixedBitString<N>) -> u16 {
    (0..N.min(16)).map(|n| u16::from(bits[n]) << n).sum()
}
