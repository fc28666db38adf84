//! The advanced emergency braking system (UN R152): warns, and brakes at the last point.
//!
//! It reads `radar/detections` and `vehicle/odometry` and nothing else, with a tracking of its own
//! ([`mod@objects`]; the controller's perception uses other code and other methods) and
//! a decision of its own:
//!
//! ```text
//! detections ─► Objects ─► threats: in the path now, or soon (path) ─► smallest gap if braking begins
//!               (objects)                                              one cycle later (prediction)
//!                                                                        │ below the margin
//!                                                     Decision: monitor ─► warn ─► brake ─► hold
//! ```
//!
//! Everything but `service` is plain code: state and time are arguments.

pub mod decision;
pub mod filter;
pub mod objects;
pub mod path;
pub mod prediction;
mod service;

pub use service::{objects, run, settings};
