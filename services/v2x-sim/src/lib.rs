//! The simulated roadside units: signal programs, phase and timing, maps; as structs or as frames.
//!
//! ```text
//! programs ─┬─ structs ──────────────────────────────► v2x/spat, v2x/map      (radio = "direct")
//!           ├─ frames ─► air: loss, delay, bit flips ─► radio/frames           (radio = "frames")
//!           └─ all signals, without a range ──────────► truth/signals
//! plan of the road ─────► map of curves ───────────► v2x/curves
//! slopes of the road ───► map of grades ───────────► v2x/preview
//! other egos in SUMO ────► CAMs ─► air, or structs ──► radio/frames, or v2x/motions
//! frames of another host or a capture ─► link ────────► radio/frames           (radio = "udp://…")
//! ```
//!
//! Everything except `service` and `link` is plain code: times are arguments.
//!
//! ```
//! use scenario::{Scenario, builtin};
//! use v2x_sim::roadside_unit::RoadsideUnit;
//!
//! let corridor = Scenario::parse("corridor", builtin::find("corridor").expect("built in").text)?;
//! let unit = RoadsideUnit::new(&corridor.v2x);
//! let received = unit.received(0, 0.0);
//! assert_eq!((received.count, received.lanes[0].stop_line_m), (1, 300.0));
//! assert_eq!(received.signals[0].intervals[0].likely_end_s, 27.0);
//! # Ok::<(), scenario::ScenarioError>(())
//! ```

pub mod air;
pub mod cell_map;
pub mod frames;
mod link;
pub mod numbers;
pub mod program;
pub mod report;
pub mod roadside_unit;
mod service;
pub mod unit_clock;

pub use service::run;
