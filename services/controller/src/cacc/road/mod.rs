//! Road.
mod config;
pub use config::RoadConfig;
