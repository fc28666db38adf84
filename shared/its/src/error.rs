//! Errors of frames.

/// Reason why bytes are not a frame that this crate reads.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    #[error("{0} bytes, expected at most {max}", max = crate::MAX_FRAME_BYTES)]
    TooLong(usize),
    /// The bytes end inside a header, or before the announced end of the payload.
    #[error("{found} bytes where {expected} were announced")]
    Truncated { expected: usize, found: usize },
    #[error("GeoNetworking version {0}, expected 1")]
    Version(u8),
    /// A signed packet (IEEE 1609.2, ETSI TS 103 097) in its envelope.
    #[error("a signed packet, expected one without its envelope")]
    Secured,
    #[error("the envelope of a packet is broken at {0}")]
    Envelope(&'static str),
    /// Not a single-hop broadcast with BTP-B.
    #[error("header type {header_type:#04x} with next header {next_header}, expected 0x50 with 2")]
    OtherHeader { header_type: u8, next_header: u8 },
    #[error("BTP port {0}, expected 2001, 2003 or 2004")]
    Port(u16),
    #[error("message id {found} on BTP port {port}")]
    MessageId { port: u16, found: u8 },
    #[error("protocol version {found} of message id {message_id}, expected 1 or 2")]
    ProtocolVersion { message_id: u8, found: u8 },
    #[error("no message in unaligned PER: {0}")]
    Payload(#[from] PayloadError),
}

/// Reason why a payload is not the message that its header names.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PayloadError {
    #[error("{what} {value}, expected {least} to {most}")]
    Range { what: &'static str, value: i64, least: i64, most: i64 },
    /// A field ends after the last bit.
    #[error("the message ends inside the field that begins at bit {bit}")]
    Ends { bit: u64 },
    /// A length in fragments of 16 Ki.
    #[error("a length of 16384 or more, more than fits into a frame")]
    Length,
    /// A CAM of a roadside unit, or of another kind of station.
    #[error("a CAM that is not a vehicle's")]
    OtherStation,
}

/// Reason why a message cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    #[error("outside the standard's range: {0}")]
    Range(String),
    #[error("{0} bytes, a frame has at most {max}", max = crate::MAX_FRAME_BYTES)]
    TooLong(usize),
}
