//! Carriers of radio frames between a roadside unit and vehicles on other hosts.
//!
//! A frame is a byte string of at most [`MAX_FRAME`] bytes, which a carrier does not look into: in timegap
//! a GeoNetworking packet without a link header. A [`Carrier`] is opened from a
//! [`CarrierAddress`](scenario::carrier::CarrierAddress):
//!
//! * UDP, to a multicast group or to one vehicle;
//! * zenoh (feature `zenoh`), as its configuration file says;
//! * a capture, whose frames become due as run time passes.
//!
//! ```text
//!  loop ── send ──► socket (never waits) / bounded queue ─► thread ─► zenoh
//!  loop ◄─ receive ── bounded queue ◄── receive thread ◄── socket, zenoh
//! ```
//!
//! Neither [`Carrier::send`] nor [`Carrier::receive`] waits or allocates. What does not fit is dropped and
//! counted. Live carriers put an envelope around each frame: the sender's number, a sequence number, its
//! wall clock and the wall-clock start of its run. From it a receiver counts what was lost on the way;
//! and by questions and answers over the same carrier a vehicle estimates how far the roadside unit's
//! clock is from its own ([`ClockDifference`]). A datagram without the envelope, of a unit that is not
//! timegap's, is a frame too: without a stamp, and nothing can be counted as lost.

mod capture;
mod carrier;
mod clock;
mod counts;
mod endpoint;
mod envelope;
mod error;
mod frame;
mod listener;
mod sequence;
mod stations;
mod udp;
#[cfg(feature = "zenoh")]
mod zenoh;

pub use capture::{Capture, CaptureError};
pub use carrier::{Carrier, Role};
pub use clock::{ClockComparison, ClockDifference};
pub use counts::{RadioReport, StationReport};
pub use error::{OpenError, SendError};
pub use frame::{Frame, MAX_FRAME};

/// This host's wall clock, ns since the Unix epoch.
#[must_use]
pub fn wall_clock_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |since| i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
