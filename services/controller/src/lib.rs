//! The control laws and the control loop.

pub mod law;
pub mod six_mode;
