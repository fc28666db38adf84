//! Whole trips: the truck on a road under a driver, and what it burnt.
//!
//! Pure and repeatable: the plant of [`truck_model`], a control period of 0.1 s, no services.

mod bound;
mod cruise;
mod human;
mod road;
mod trip;

pub use bound::Bound;
pub use cruise::Cruise;
pub use human::Human;
pub use road::Road;
pub use trip::{CONTROL_PERIOD_S, Driver, Seen, Trip, drive};
