//! The interface between a live carrier, its receive thread and its owner.

use crate::error::SendError;
use std::net::SocketAddr;
use std::time::Duration;

/// Origin of a packet, for questions to its sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A socket.
    Socket(SocketAddr),
    /// A member of the same zenoh network.
    #[cfg(feature = "zenoh")]
    Zenoh,
}

/// Result of waiting for a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// A packet of this many bytes is in the buffer.
    Packet(usize, Origin),
    /// No packet: the time is over, or the wait was interrupted.
    Nothing,
    /// The carrier was closed.
    Closed,
}

/// Purpose of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A question to a roadside unit.
    Question,
    /// An answer for the station with this number.
    Answer(u64),
}

/// The receiving end, owned by the receive thread.
pub(crate) trait Endpoint: Send {
    /// Waits for a packet, at most `timeout`.
    fn receive(&mut self, timeout: Duration, buffer: &mut [u8]) -> Received;

    /// Sends a question or an answer. A lost one is repeated later.
    fn send(&mut self, to: Origin, purpose: Purpose, packet: &[u8]);
}

/// The sending end, owned by the carrier's owner. It never waits.
pub(crate) trait Outlet: Send {
    /// Passes a packet to the network.
    fn send(&mut self, packet: &[u8]) -> Result<(), SendError>;

    /// Ends the wait of the receiving end permanently.
    fn close(&mut self);
}
