//! Whole trips: the truck on a road under a driver, and what it burnt.
//!
//! Pure and repeatable: the plant of [`truck_model`], a control period of 0.1 s, no services.

mod assisted;
mod bound;
mod chase;
mod comparison;
mod cruise;
mod equal_time;
mod human;
mod ordinary_acc;
mod road;
mod trip;

pub use assisted::{Assisted, Map};
pub use bound::Bound;
pub use chase::{Chase, Follower, Lead, Moment, Noise, chase};
pub use comparison::Comparison;
pub use cruise::Cruise;
pub use equal_time::{EQUAL_TIME, at_equal_time};
pub use human::Human;
pub use ordinary_acc::OrdinaryAcc;
pub use road::Road;
pub use trip::{CONTROL_PERIOD_S, Driver, Sample, Seen, Trip, drive};
