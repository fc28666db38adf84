//! The control laws and the control loop.

pub mod cacc;
pub mod law;
