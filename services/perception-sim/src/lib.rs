//! The other vehicles, the radar that sees them and the tracker behind it.

pub mod perception;
pub mod radar;
mod service;
pub mod target_selection;
pub mod tracker;
pub mod traffic;

pub use service::run;
