//! The messages that are read here, by their kinds.

use crate::cam::Cam;
use crate::mapem::Mapem;
use crate::spatem::Spatem;

/// A message of one of the kinds that are read here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Signal phase and timing.
    Spatem(Spatem),
    /// Geometry of intersections.
    Mapem(Mapem),
    /// A vehicle's motion.
    Cam(Cam),
}

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MessageKind {
    /// [`Message::Spatem`].
    Spatem,
    /// [`Message::Mapem`].
    Mapem,
    /// [`Message::Cam`].
    Cam,
}

impl MessageKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Spatem, Self::Mapem, Self::Cam];

    /// Its port of BTP-B (ETSI TS 103 248).
    #[must_use]
    pub const fn port(self) -> u16 {
        match self {
            Self::Cam => 2001,
            Self::Mapem => 2003,
            Self::Spatem => 2004,
        }
    }

    /// The id of its message (ETSI TS 102 894-2).
    #[must_use]
    pub const fn message_id(self) -> u8 {
        match self {
            Self::Cam => 2,
            Self::Spatem => 4,
            Self::Mapem => 5,
        }
    }

    /// Its traffic class: CAM 2 by EN 302 637-2, the infrastructure's one step behind.
    pub(crate) const fn traffic_class(self) -> u8 {
        match self {
            Self::Cam => 2,
            Self::Mapem | Self::Spatem => 3,
        }
    }
}

impl Message {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> MessageKind {
        match self {
            Self::Spatem(_) => MessageKind::Spatem,
            Self::Mapem(_) => MessageKind::Mapem,
            Self::Cam(_) => MessageKind::Cam,
        }
    }

    /// Station id of its sender.
    #[must_use]
    pub fn station_id(&self) -> u32 {
        match self {
            Self::Spatem(message) => message.station_id,
            Self::Mapem(message) => message.station_id,
            Self::Cam(message) => message.station_id,
        }
    }
}
