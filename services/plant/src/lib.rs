//! The simulated ego vehicle: its motion, its actuator gateway and the referee of a run.

pub mod ahead;
pub mod brake;
mod braking;
pub mod chains;
mod clear;
pub mod delivery;
pub mod ego;
pub mod gateway;
pub mod longitudinal;
mod parts;
pub mod referee;
pub mod report;
mod service;
pub mod signal_chain;
mod surroundings;
pub mod timeliness;
mod times;
pub mod truck;
mod truth;
pub mod wheel_energy;
mod worst;

pub use service::{last_known, run};
