//! The supported messages and their kinds.

use crate::cam::Cam;
use crate::mapem::Mapem;
use crate::spatem::Spatem;

/// A message of a supported kind.
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
///
/// ```
/// use its::MessageKind;
///
/// let ports = MessageKind::ALL.map(|kind| (kind.port(), kind.message_id()));
/// assert_eq!(ports, [(2004, 4), (2003, 5), (2001, 2)]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MessageKind {
    Spatem,
    Mapem,
    Cam,
}

impl MessageKind {
    pub const ALL: [Self; 3] = [Self::Spatem, Self::Mapem, Self::Cam];

    /// Port of BTP-B (ETSI TS 103 248).
    pub const fn port(self) -> u16 {
        self.numbers().0
    }

    /// Message id (ETSI TS 102 894-2).
    pub const fn message_id(self) -> u8 {
        self.numbers().1
    }

    /// Traffic class: CAM 2 by EN 302 637-2, the infrastructure one step lower.
    pub(crate) const fn traffic_class(self) -> u8 {
        self.numbers().2
    }

    const fn numbers(self) -> (u16, u8, u8) {
        match self {
            Self::Cam => (2001, 2, 2),
            Self::Mapem => (2003, 5, 3),
            Self::Spatem => (2004, 4, 3),
        }
    }
}

impl Message {
    pub fn kind(&self) -> MessageKind {
        match self {
            Self::Spatem(_) => MessageKind::Spatem,
            Self::Mapem(_) => MessageKind::Mapem,
            Self::Cam(_) => MessageKind::Cam,
        }
    }

    pub fn station_id(&self) -> u32 {
        match self {
            Self::Spatem(message) => message.station_id,
            Self::Mapem(message) => message.station_id,
            Self::Cam(message) => message.station_id,
        }
    }
}
