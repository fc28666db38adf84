//! The simulated roadside unit: signal programs, signal phase and timing, map; as structs or as frames.
//! In its place a carrier of frames of other hosts can be.

pub mod air;
pub mod frames;
mod link;
pub mod program;
pub mod road_map;
pub mod roadside_unit;
mod service;
pub mod unit_clock;

pub use service::run;
