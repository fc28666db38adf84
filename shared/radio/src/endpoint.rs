//! The interface between a live carrier, its receive thread and its owner.

use crate::error::SendError;
use std::net::SocketAddr;
use std::time::Duration;

/// Origin of a packet, for questions to its sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
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
    Closed,
}

/// The receiving end, owned by the receive thread.
pub(crate) trait Endpoint: Send {
    /// Waits for a packet, at most `timeout`.
    fn receive(&mut self, timeout: Duration, buffer: &mut [u8]) -> Received;

    /// Sends an answer to the station with the number `asker`, or else a question to a roadside unit. A lost one is
    /// repeated later.
    fn send(&mut self, to: Origin, asker: Option<u64>, packet: &[u8]);
}

/// The sending end, owned by the carrier's owner. It never waits.
pub(crate) trait Outlet: Send + std::fmt::Debug {
    /// Passes a packet to the network.
    fn send(&mut self, packet: &[u8]) -> Result<(), SendError>;

    /// Ends the wait of the receiving end permanently.
    fn close(&mut self);
}
