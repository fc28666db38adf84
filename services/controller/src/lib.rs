//! The control laws and the control loop.
//!
//! A law is plain code behind one trait ([`law::Law`]) and a descriptor ([`law::Descriptor`]) in the registry
//! ([`laws::ALL`]). The loop samples the topics ([`sampling`]), asks the law and publishes: [`run`] takes the
//! law that the scenario names. [`run_law`] takes one that you bring along, and [`serve`] makes it a program.
//! [`run_asked`] takes one that the caller of a run in one process computes.

pub mod curve_speed;
pub mod following;
pub mod ladder;
pub mod law;
pub mod laws;
mod planning_thread;
pub mod plausibility;
pub mod report;
pub mod sampling;
mod service;
pub mod settings;

pub use service::{last_law_times, run, run_asked, run_law, serve};
