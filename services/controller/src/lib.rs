//! The control laws and the control loop.

pub mod law;
pub mod quadratic_bounded;
pub mod six_mode;
