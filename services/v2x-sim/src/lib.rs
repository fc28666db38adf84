//! The simulated roadside unit: signal programs, signal phase and timing, map.

pub mod program;
pub mod road_map;
pub mod roadside_unit;
mod service;

pub use service::run;
