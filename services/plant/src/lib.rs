//! The simulated ego vehicle: its motion, its actuator gateway and the referee of a run.
//!
//! Each period the plant publishes the ego's motion, takes the newest command and moves on:
//!
//! ```text
//! control/command ──> delivery ──> gateway ──┐
//!                                            ├──> ego ──> vehicle/odometry, truth/ego
//! safety/brake ─────> brake ─────────────────┘     ├────> lateral ──> vehicle/lateral, truth/pose
//!                                                  └────> referee ──> summary
//! ```
//!
//! The models are plain code, and only `service` touches the runtime. A vehicle alone:
//!
//! ```
//! use plant::longitudinal::Vehicle;
//! use scenario::plant::Plant;
//!
//! let mut car = Vehicle::new(&Plant::default());
//! for _ in 0..100 {
//!     car.step(2.0); // A request of 2 m/s² over one period of 10 ms.
//! }
//! let speed_mps = car.state().speed_mps;
//! assert!((1.0..2.0).contains(&speed_mps), "the actuator's lag costs some of the 2 m/s");
//! ```

pub mod ahead;
mod brake;
mod chains;
mod clear;
pub mod contact;
mod delivery;
mod ego;
pub mod gateway;
pub mod lateral;
pub mod longitudinal;
pub mod numbers;
mod parts;
pub mod referee;
pub mod report;
mod service;
mod signal_chain;
pub mod surroundings;
mod timeliness;
pub mod truck;
mod unit_car;
mod wheel_energy;
mod worst;

pub use service::{last_known, run};
