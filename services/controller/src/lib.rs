//! The control laws and the control loop.

pub mod law;
