//! A message with its headers, and its bytes.

use crate::codec;
use crate::geonetworking::{HEADER_BYTES, Headers, Source};
use crate::message::{Message, MessageKind};
use crate::{DecodeError, EncodeError};

/// Longest frame, bytes, without the header of the link.
pub const MAX_FRAME_BYTES: usize = 1500;

/// A message with the sender's data of its headers.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub source: Source,
    pub message: Message,
}

impl Frame {
    /// The frame as bytes, at most [`MAX_FRAME_BYTES`].
    ///
    /// # Errors
    /// [`EncodeError`] if a value is outside the standard's range or the frame is too long.
    pub fn encode(&self) -> Result<Vec<u8>, EncodeError> {
        let payload = codec::encode(&self.message)?;
        let bytes = HEADER_BYTES + payload.len();
        if bytes > MAX_FRAME_BYTES {
            return Err(EncodeError::TooLong(bytes));
        }
        let kind = self.message.kind();
        let headers =
            Headers { source: self.source, traffic_class: kind.traffic_class(), port: kind.port() };
        let mut frame = Vec::with_capacity(bytes);
        headers.write(payload.len() as u16, &mut frame);
        frame.extend(payload);
        Ok(frame)
    }

    /// Reads a frame. Bytes after the announced payload are ignored.
    ///
    /// # Errors
    /// [`DecodeError`] describes the fault.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        if bytes.len() > MAX_FRAME_BYTES {
            return Err(DecodeError::TooLong(bytes.len()));
        }
        let (headers, payload) = Headers::read(bytes)?;
        let port = headers.port;
        let kind = MessageKind::ALL.into_iter().find(|kind| kind.port() == port);
        let kind = kind.ok_or(DecodeError::Port(port))?;
        // `ItsPduHeader`: version and message id of one byte each, station id of four.
        let [version, message_id, ..] = *payload else {
            return Err(DecodeError::Truncated { expected: 6, found: payload.len() });
        };
        // The second byte of another version need not be a message id. A `MessageFrame` of SAE J2735, as in
        // North America, begins with 0 and its own id.
        if !(1..=2).contains(&version) {
            return Err(DecodeError::ProtocolVersion { message_id, found: version });
        }
        if message_id != kind.message_id() {
            return Err(DecodeError::MessageId { port, found: message_id });
        }
        Ok(Self { source: headers.source, message: codec::decode(kind, payload)? })
    }
}
