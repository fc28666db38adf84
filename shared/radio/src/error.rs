//! Errors of opening and using a carrier.

use crate::capture::CaptureError;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Reason why a carrier was not opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The address is not available.
    #[error("cannot listen on {address}: {source}")]
    Bind { address: SocketAddr, source: io::Error },
    /// The group cannot be joined.
    #[error(
        "cannot join the multicast group {address}: {source}; name the interface, as in \
         udp://{address}?interface=eth0"
    )]
    Join { address: SocketAddr, source: io::Error },
    /// The interface does not exist.
    #[error("no network interface `{name}`: {source}")]
    Interface { name: String, source: io::Error },
    /// A socket or a thread cannot be set up.
    #[error("cannot set up the carrier: {0}")]
    SetUp(#[source] io::Error),
    /// The capture cannot be played.
    #[error("{}: {source}", path.display())]
    Capture { path: PathBuf, source: CaptureError },
    /// A capture is read-only.
    #[error("a capture cannot be sent to: use udp:// or zenoh")]
    CaptureIsNoTarget,
    /// This program was built without zenoh.
    #[error(
        "this program was built without zenoh: build it with `--features zenoh`, or use udp://"
    )]
    WithoutZenoh,
    /// zenoh's configuration cannot be read.
    #[error("zenoh's configuration {}: {reason}", path.display())]
    ZenohConfiguration {
        path: PathBuf,
        /// zenoh's error.
        reason: String,
    },
    /// zenoh cannot open a session.
    #[error(
        "zenoh opens no session: {0}; is the router there, and do the certificates belong \
         together?"
    )]
    ZenohSession(String),
}

/// Reason why a frame was not sent; it is also counted.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    #[error("a frame of {0} bytes, expected at most {max}", max = crate::MAX_FRAME)]
    TooLong(usize),
    /// No station is known yet.
    #[error("no receiving station is known yet")]
    NoTarget,
    /// The queue to the network is full.
    #[error("the queue to the network is full")]
    Full,
    #[error("the kernel refused the frame: {0}")]
    Kernel(#[source] io::Error),
    /// A capture is not sent to.
    #[error("a capture cannot be sent to")]
    Capture,
}
