//! Carriers of radio frames between a roadside unit and vehicles on other hosts.
//!
//! ```text
//!  loop ── send ──► socket (never waits) / bounded queue ─► thread ─► zenoh
//!  loop ◄─ receive ── bounded queue ◄── receive thread ◄── socket, zenoh
//! ```
//!
//! A frame is a byte string of at most [`MAX_FRAME`] bytes; in timegap it is a GeoNetworking packet. A
//! [`Carrier`] is opened from a [`CarrierAddress`](scenario::carrier::CarrierAddress):
//!
//! * UDP, to a multicast group or to one vehicle;
//! * zenoh (feature `zenoh`), by its configuration file;
//! * a capture, whose frames become due as run time passes.
//!
//! [`Carrier::send`] and [`Carrier::receive`] neither wait nor allocate. Frames without room are dropped and counted.
//! Live carriers put an envelope around each frame. It has the sender's number, a sequence number, its wall clock, and
//! the wall-clock start of its run. With it a receiver counts losses. By questions and answers over the same carrier, a
//! vehicle estimates the difference to the roadside unit's clock ([`ClockDifference`]). A datagram without the
//! envelope, from another program, is a frame too. It has no stamp and no count of losses.
//!
//! ```
//! use radio::{Carrier, Role, wall_clock_ns};
//!
//! # let socket = std::net::UdpSocket::bind("127.0.0.1:0")?;
//! # let port = socket.local_addr()?.port();
//! # drop(socket);
//! let address = format!("udp://127.0.0.1:{port}").parse()?;
//! let mut vehicle = Carrier::open(&address, Role::Vehicle)?;
//! let mut unit = Carrier::open(&address, Role::Roadside { start_ns: wall_clock_ns() })?;
//! unit.send(b"a frame")?;
//! let frame = loop {
//!     match vehicle.receive(0) {
//!         Some(frame) => break frame,
//!         None => std::thread::yield_now(),
//!     }
//! };
//! assert_eq!(frame.bytes(), b"a frame");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod capture;
mod carrier;
mod clock;
#[cfg(test)]
mod effect_tests;
mod endpoint;
mod envelope;
mod error;
mod frame;
mod listener;
mod numbers;
mod sequence;
mod stations;
mod udp;
#[cfg(feature = "zenoh")]
mod zenoh;

pub use capture::{Capture, CaptureError};
pub use carrier::{Carrier, Role};
pub use clock::{ClockComparison, ClockDifference};
pub use error::{OpenError, SendError};
pub use frame::{Frame, MAX_FRAME};
pub use stations::{RadioReport, StationReport};

/// This host's wall clock, ns since the Unix epoch.
pub fn wall_clock_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |since| i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
