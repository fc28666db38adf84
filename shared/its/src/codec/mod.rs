//! Between this crate's messages and those that are generated from the standards' ASN.1.

pub(crate) mod cam;
pub(crate) mod mapem;
pub(crate) mod spatem;
mod uper;

use crate::DecodeError;
use rasn::types::FixedBitString;

/// Version of the messages that are sent.
const PROTOCOL_VERSION: u8 = 2;

fn from_uper<T: rasn::Decode>(payload: &[u8]) -> Result<T, DecodeError> {
    rasn::uper::decode(payload).map_err(|e| DecodeError::Payload(e.kind.to_string()))
}

/// A bit string of the standard: its bit n is bit n of the flags.
fn flags<const N: usize>(bits: &FixedBitString<N>) -> u16 {
    (0..N.min(16)).map(|n| u16::from(bits[n]) << n).sum()
}
