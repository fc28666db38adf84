//! What a live carrier is to its receive thread and to its owner.

use crate::error::SendError;
use std::net::SocketAddr;
use std::time::Duration;

/// Where a packet came from, so that its sender can be asked something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A socket.
    Socket(SocketAddr),
    /// A member of the same zenoh network.
    #[cfg(feature = "zenoh")]
    Zenoh,
}

/// What came of waiting for a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// A packet of that many bytes is in the buffer.
    Packet(usize, Origin),
    /// Nothing yet: the time is over, or the wait was interrupted.
    Nothing,
    /// The carrier was closed.
    Closed,
}

/// What a packet is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A question to a roadside unit.
    Question,
    /// The answer to one, for the station of that number.
    Answer(u64),
}

/// The receiving end, which the receive thread owns.
pub(crate) trait Endpoint: Send {
    /// Waits for a packet, at most `timeout`.
    fn receive(&mut self, timeout: Duration, buffer: &mut [u8]) -> Received;

    /// Sends a question or an answer. What cannot be sent is not: it is asked again.
    fn send(&mut self, to: Origin, purpose: Purpose, packet: &[u8]);
}

/// The sending end, which the carrier's owner has. It never waits.
pub(crate) trait Outlet: Send {
    /// Hands a packet to the network.
    fn send(&mut self, packet: &[u8]) -> Result<(), SendError>;

    /// Ends the wait of the receiving end for good.
    fn close(&mut self);
}
