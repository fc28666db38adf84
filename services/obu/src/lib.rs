//! The on-board unit: decodes, checks and hands on what is on air, outside the control loop.
//!
//! ```text
//! radio/frames ─► decode ─► own station? stamps? bytes heard before? ─► SPATEM, MAPEM by intersection
//!                                                                              │ agree? heard twice?
//! vehicle/odometry ─► path ahead ────────────────────────────────► stop lines, timing ─► v2x/map, v2x/spat
//!         └─────────► CAM when due ─► radio/sent
//! ```
//!
//! Everything but `service` is plain code: frames and times are arguments.

pub mod awareness;
pub mod clock;
pub mod intersection;
pub mod known_map;
pub mod lanes;
pub mod receiver;
mod service;
pub mod timing;
pub mod verdict;

pub use service::{last_known, run};
