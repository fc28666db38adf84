//! The simulated roadside unit: signal programs, signal phase and timing, map; as structs or as frames.

pub mod air;
pub mod frames;
pub mod program;
pub mod road_map;
pub mod roadside_unit;
mod service;

pub use service::run;
