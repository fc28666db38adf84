//! Errors of opening and using a carrier.

use crate::capture::CaptureError;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Reason why a carrier was not opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error("cannot listen on {address}: {source}")]
    Bind { address: SocketAddr, source: io::Error },
    #[error(
        "cannot join the multicast group {address}: {source}; name the interface, as in \
         udp://{address}?interface=eth0"
    )]
    Join { address: SocketAddr, source: io::Error },
    #[error("no network interface `{name}`: {source}")]
    Interface { name: String, source: io::Error },
    #[error("cannot set up the carrier: {0}")]
    SetUp(#[source] io::Error),
    #[error("{}: {source}", path.display())]
    Capture { path: PathBuf, source: CaptureError },
    #[error("a capture cannot be sent to: use udp:// or zenoh")]
    CaptureIsNoTarget,
    #[error(
        "this program was built without zenoh: build it with `--features zenoh`, or use udp://"
    )]
    WithoutZenoh,
    #[error("zenoh's configuration {}: {reason}", path.display())]
    ZenohConfiguration {
        path: PathBuf,
        /// zenoh's error.
        reason: String,
    },
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
    #[error("no receiving station is known yet")]
    NoTarget,
    #[error("the queue to the network is full")]
    Full,
    #[error("the kernel refused the frame: {0}")]
    Kernel(#[source] io::Error),
    #[error("a capture cannot be sent to")]
    Capture,
}
