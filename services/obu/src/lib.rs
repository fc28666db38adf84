//! The on-board unit: decodes and checks the frames on air, outside the control loop.
//!
//! ```text
//! radio/frames ─► decode ─► own station? stamps? same bytes again? ─► SPATEM, MAPEM by intersection
//!                                                                              │ agree? received twice?
//! radio/frames ─► CAMs of other vehicles ──────────────────────────────────────────────────► v2x/motions
//! vehicle/odometry ─► path ahead ────────────────────────────────► stop lines, timing ─► v2x/map, v2x/spat
//!         └─────────► CAM when due ─► radio/sent
//! ```
//!
//! Everything except `service` is plain code: frames and times are arguments.
//!
//! ```
//! use its::geodesy::{Plane, Position};
//! use obu::clock::Moment;
//! use obu::receiver::Receiver;
//! use obu::verdict::Verdict;
//!
//! let plane = Plane::along(Position { latitude: 0, longitude: 0 }, 90.0);
//! let mut unit = Receiver::new(4711, 1000, plane);
//! let moment = Moment { now_ns: 0, utc_start_ns: 1_780_315_200_000_000_000, ahead_ns: 0 };
//! assert_eq!(unit.take(b"not a frame", &moment), Verdict::OtherProfile);
//! assert_eq!(unit.take(b"not a frame", &moment), Verdict::Duplicated);
//! assert_eq!(unit.verdicts.of(Verdict::OtherProfile), 1);
//! ```

pub mod awareness;
pub mod clock;
pub mod intersection;
pub mod known_map;
pub mod lanes;
pub mod numbers;
pub mod receiver;
pub mod report;
mod service;
pub mod timing;
pub mod verdict;

pub use service::{last_known, run};
