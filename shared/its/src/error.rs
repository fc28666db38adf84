//! Errors of frames.

/// Reason why bytes are not a frame that this crate reads.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// Longer than any frame.
    #[error("{0} bytes, expected at most {max}", max = crate::MAX_FRAME_BYTES)]
    TooLong(usize),
    /// The bytes end inside a header, or before the announced end of the payload.
    #[error("{found} bytes where {expected} were announced")]
    Truncated {
        /// Announced length, bytes.
        expected: usize,
        /// Present length, bytes.
        found: usize,
    },
    /// Another version of GeoNetworking.
    #[error("GeoNetworking version {0}, expected 1")]
    Version(u8),
    /// A signed packet (IEEE 1609.2, ETSI TS 103 097) in its envelope.
    #[error("a signed packet, expected one without its envelope")]
    Secured,
    /// The envelope of a signed packet is broken, or not one of `signedData`.
    #[error("the envelope of a packet is broken at {0}")]
    Envelope(&'static str),
    /// Not a single-hop broadcast with BTP-B.
    #[error("header type {header_type:#04x} with next header {next_header}, expected 0x50 with 2")]
    OtherHeader { header_type: u8, next_header: u8 },
    /// A port of another kind of message.
    #[error("BTP port {0}, expected 2001, 2003 or 2004")]
    Port(u16),
    /// A message id that does not belong to the port.
    #[error("message id {found} on BTP port {port}")]
    MessageId {
        port: u16,
        /// Id in the message.
        found: u8,
    },
    /// Another version of the message.
    #[error("protocol version {found} of message id {message_id}, expected 1 or 2")]
    ProtocolVersion {
        message_id: u8,
        /// Protocol version.
        found: u8,
    },
    /// The payload is not the message that its header names.
    #[error("no message in unaligned PER: {0}")]
    Payload(#[from] PayloadError),
}

/// Reason why a payload is not the message that its header names.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PayloadError {
    /// A number is outside the standard's bounds.
    #[error("{what} {value}, expected {least} to {most}")]
    Range {
        what: &'static str,
        value: i64,
        /// Its lowest value.
        least: i64,
        /// Its highest value.
        most: i64,
    },
    /// A field ends after the last bit.
    #[error("the message ends inside the field that begins at bit {bit}")]
    Ends {
        /// First bit of the field.
        bit: u64,
    },
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
    /// A value is outside the standard's range.
    #[error("outside the standard's range: {0}")]
    Range(String),
    /// More than fits into a frame.
    #[error("{0} bytes, a frame has at most {max}", max = crate::MAX_FRAME_BYTES)]
    TooLong(usize),
}
