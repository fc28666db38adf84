//! Messages to unaligned PER and back.
//!
//! One walk over the fields of a message writes and reads it. It has the parts in this crate's types. The tables of
//! `dsrc` (SPATEM, MAPEM) and `container` (CAM) check all other parts of the standards and skip them.

mod cam;
mod container;
mod dsrc;
mod mapem;
#[cfg(all(test, feature = "oracle"))]
mod oracle_tests;
mod spatem;
mod uper;

use crate::{EncodeError, Message, MessageKind, PayloadError};
use uper::{Fields, Number, Reader, Writer};

/// Version of encoded messages.
const SENT_VERSION: i64 = 2;
const PROTOCOL_VERSION: Number = Number::new("protocol version", 0, 255);
const MESSAGE_ID: Number = Number::new("message id", 0, 255);
const STATION_ID: Number = Number::new("station id", 0, 4_294_967_295);
const LATITUDE: Number = Number::new("latitude", -900_000_000, 900_000_001);
const LONGITUDE: Number = Number::new("longitude", -1_800_000_000, 1_800_000_001);

pub(crate) fn encode(message: &Message) -> Result<Vec<u8>, EncodeError> {
    let mut to = Writer::default();
    // A walk has its message at hand to fill it; the writer leaves it as it is.
    walk(&mut to, &mut message.clone()).map_err(|error| EncodeError::Range(error.to_string()))?;
    Ok(to.finish())
}

/// The message of this kind in a payload. The frame has checked its version and id.
pub(crate) fn decode(kind: MessageKind, payload: &[u8]) -> Result<Message, PayloadError> {
    read(kind, &mut Reader::new(payload))
}

fn read(kind: MessageKind, from: &mut impl Fields) -> Result<Message, PayloadError> {
    let mut message = match kind {
        MessageKind::Spatem => Message::Spatem(Default::default()),
        MessageKind::Mapem => Message::Mapem(Default::default()),
        MessageKind::Cam => Message::Cam(Default::default()),
    };
    walk(from, &mut message)?;
    Ok(message)
}

/// `ItsPduHeader`, then the message.
fn walk(fields: &mut impl Fields, message: &mut Message) -> Result<(), PayloadError> {
    fields.whole(PROTOCOL_VERSION, SENT_VERSION)?;
    fields.whole(MESSAGE_ID, message.kind().message_id().into())?;
    match message {
        Message::Spatem(message) => spatem::walk(fields, message),
        Message::Mapem(message) => mapem::walk(fields, message),
        Message::Cam(message) => cam::walk(fields, message),
    }
}
