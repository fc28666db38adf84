//! The control laws and the control loop.
//!
//! A law is plain code behind one trait ([`law::Law`]); [`laws`] builds the one that a scenario
//! names. The loop ([`run`]) samples the topics ([`sampling`]), asks the law and publishes.

pub mod cacc;
pub mod ladder;
pub mod law;
pub mod laws;
mod planning;
pub mod plausibility;
pub mod predictive;
pub mod quadratic_bounded;
pub mod sampling;
mod service;
pub mod six_mode;

pub use service::run;
