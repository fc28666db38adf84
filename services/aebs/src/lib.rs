//! The advanced emergency braking system (UN R152): warns, and brakes at the last point.
//!
//! It reads `radar/detections` and `vehicle/odometry` and nothing else. Its tracking ([`mod@objects`]) shares no code
//! and no method with the controller's perception, and its decision is its own:
//!
//! ```text
//! detections ─► Objects ─► when the ego is beside each: if it keeps on, if it brakes now, one cycle
//!               (objects)  later (prediction) ─► probability that the object is in the path then
//!                                                                 │ contact likely, last point reached
//!                                              Decision: monitor ─► warn ─► brake ─► hold
//! ```
//!
//! On a road with curves it reads `vehicle/lateral` too, and counts places along the circle that the ego drives
//! ([`mod@circle`]). It uses no other estimate of the road: a fault of the controller's perception does not reach it.
//! An object that stands on a row across this circle is braked for late (`row`). A straight road is the circle of
//! curvature 0.
//!
//! It also looks at each object that is about to hit another one, as it will stand there
//! ([`Objects::threats`](objects::Objects::threats)).
//!
//! Everything but `service` is plain code: state and time are arguments.

pub mod circle;
mod collision_ahead;
pub mod decision;
pub mod filter;
pub mod object;
pub mod objects;
mod point;
pub mod prediction;
pub mod report;
mod row;
mod service;
pub mod sight;
mod sighting;

pub use service::{last_known, objects, own_way, run, settings, sight};
