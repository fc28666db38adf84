//! The other vehicles, the radar that sees them and the tracker behind it.
//!
//! ```text
//! truth/ego ─► traffic ─► radar ─► detections ─► tracking ─► tracks, target ─► radar/tracks
//!                 └──────────────────── quality: tracks against the traffic ─► summary
//! ```
//!
//! [`traffic`] moves the other vehicles, and [`radar`] sees them. [`tracking`] makes tracks of the detections, and
//! [`quality`] compares these with the traffic. [`perception`] is one step of all. All of it is plain code: functions
//! of state, seed and time. Only the service has a clock and ports.
//!
//! ```
//! use bytemuck::Zeroable;
//! use messages::{Detection, MAX_DETECTIONS};
//! use perception_sim::perception::Perception;
//! use perception_sim::radar::scene::Ego;
//! use scenario::{Scenario, builtin};
//!
//! let text = builtin::find("following").expect("it is built in").text;
//! let scenario = Scenario::parse("following", text)?;
//! let mut perception = Perception::new(&scenario);
//! let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
//! let ego = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
//! let tracks = perception.step(0, &ego, &mut detections);
//! assert!(tracks.target().is_some(), "the lead is in the ego's path");
//! # Ok::<(), scenario::ScenarioError>(())
//! ```

#![allow(clippy::needless_range_loop, reason = "indices of matrices, as in the equations")]
#![allow(clippy::large_enum_variant, reason = "one of each exists in a process")]

mod assignment;
pub mod perception;
mod plane;
mod poses;
pub mod quality;
pub mod radar;
pub mod random;
pub mod report;
mod service;
mod stage;
mod sumo_world;
pub mod tracking;
pub mod traffic;
pub mod vehicle;
mod weaving;

pub use service::run;
pub use sumo_world::Alone;
