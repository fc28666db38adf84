//! The control laws of the four papers, and two that follow a vehicle without signals: a folder each.
//!
//! ```text
//! law (the contract) ◄─ cacc, signal_stop │ six_mode │ quadratic_bounded │ truck ─► ALL ─► controller's registry
//! ```
//!
//! A law uses the contract, the solver and the model of its vehicle. It has neither a clock nor a message.

pub mod cacc;
pub mod quadratic_bounded;
pub mod signal_stop;
pub mod six_mode;
pub mod truck;

use law::Descriptor;

/// Every law, in the order of `timegap list`.
pub static ALL: [&Descriptor; 6] = [
    &cacc::ACC_MPC,
    &cacc::CACC_MPC,
    &signal_stop::ACC_SIGNAL_STOP,
    &six_mode::SIX_MODE,
    &quadratic_bounded::QUADRATIC_BOUNDED,
    &truck::PREDICTIVE,
];
