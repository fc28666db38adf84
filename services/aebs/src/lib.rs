//! The advanced emergency braking system (UN R152): warns, and brakes at the last point.
//!
//! It reads `radar/detections` and `vehicle/odometry`. Its objects ([`mod@objects`]) share no code and no method with
//! the controller's perception, and its decision is its own:
//!
//! ```text
//! detections ─► Objects ─► when the ego is beside each: if it keeps on, if it brakes now, one cycle
//!               (objects)  later (prediction) ─► probability that the object is in the path then
//!                                                                 │ contact likely, last point reached
//!                                              Decision: monitor ─► warn ─► brake ─► hold
//! ```
//!
//! On a road with curves it reads `vehicle/lateral` and `radar/course` too, and counts places along the corridor ahead
//! ([`mod@corridor`]). The belief about the road is all that it takes from perception. The yaw rate checks it, and
//! takes its place ([`mod@way`]). A straight road is a corridor of curvature 0.
//!
//! It also looks at each object that is about to hit another one, as it will stand there
//! ([`Objects::threats`](objects::Objects::threats)).
//!
//! Everything but `service` is plain code: state and time are arguments.

mod collision_ahead;
pub mod corridor;
pub mod decision;
pub mod filter;
pub mod object;
pub mod objects;
mod point;
pub mod prediction;
mod service;
pub mod sight;
mod sighting;
pub mod way;

pub use service::{AebsReport, last_known, objects, run, settings, sight, way};
