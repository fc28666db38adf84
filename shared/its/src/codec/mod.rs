//! Messages to unaligned PER and back.
//!
//! Encoders write the parts in this crate's types. Decoders accept all parts of the standards. The tables of `dsrc`
//! (SPATEM, MAPEM) and `container` (CAM) check the others and skip them.

pub(crate) mod cam;
mod container;
mod dsrc;
pub(crate) mod mapem;
#[cfg(all(test, feature = "oracle"))]
mod oracle_tests;
pub(crate) mod spatem;
mod uper;

use crate::{EncodeError, Message, MessageKind, PayloadError};
use uper::{Number, Reader, Source, Writer};

/// Version of encoded messages.
const SENT_VERSION: u8 = 2;
const PROTOCOL_VERSION: Number = Number::new("protocol version", 0, 255);
const MESSAGE_ID: Number = Number::new("message id", 0, 255);
const STATION_ID: Number = Number::new("station id", 0, 4_294_967_295);
const LATITUDE: Number = Number::new("latitude", -900_000_000, 900_000_001);
const LONGITUDE: Number = Number::new("longitude", -1_800_000_000, 1_800_000_001);

/// The message of this kind in a payload.
pub(crate) fn decode(kind: MessageKind, payload: &[u8]) -> Result<Message, PayloadError> {
    read(kind, &mut Reader::new(payload))
}

fn read(kind: MessageKind, from: &mut impl Source) -> Result<Message, PayloadError> {
    Ok(match kind {
        MessageKind::Spatem => Message::Spatem(spatem::read(from)?),
        MessageKind::Mapem => Message::Mapem(mapem::read(from)?),
        MessageKind::Cam => Message::Cam(cam::read(from)?),
    })
}

/// A message with its `ItsPduHeader`.
fn write_header(kind: MessageKind, station_id: u32) -> Result<Writer, EncodeError> {
    let mut to = Writer::default();
    to.number(PROTOCOL_VERSION, SENT_VERSION)?;
    to.number(MESSAGE_ID, kind.message_id())?;
    to.number(STATION_ID, station_id)?;
    Ok(to)
}

/// Reads `ItsPduHeader` after the frame has checked version and id. Returns the station's id.
fn read_header(from: &mut impl Source) -> Result<u32, PayloadError> {
    from.whole(PROTOCOL_VERSION)?;
    from.whole(MESSAGE_ID)?;
    from.number(STATION_ID)
}
