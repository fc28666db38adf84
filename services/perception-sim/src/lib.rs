//! The other vehicles, the radar that sees them and the tracker behind it.
//!
//! [`traffic`] moves the other vehicles, [`radar`] sees them, [`tracking`] makes tracks of what it sees,
//! and [`quality`] compares these with the traffic. [`perception`] is one step of all. All of it is
//! plain code: functions of state, seed and time; only the service has a clock and ports.

#![allow(clippy::needless_range_loop, reason = "indices of matrices, as in the equations")]
#![allow(clippy::large_enum_variant, reason = "one of each exists in a process")]

pub mod perception;
pub mod quality;
pub mod radar;
pub mod random;
pub mod report;
mod service;
mod stage;
pub mod tracking;
pub mod traffic;
pub mod vehicle;

pub use service::{Ahead, run, run_behind};
