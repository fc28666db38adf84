//! Predictive cruise for a heavy truck (Li, Zheng, Wang, Wang; FAW Jiefang JH6).
//!
//! Planning and driving are apart, so that planning can run beside the control loop:
//!
//! ```text
//!            Input ──► Drive::request ──► PlanRequest ──► Planner::plan ──► Plan
//!                          ▲                 (any thread, any latency)        │
//!   Output ◄── Drive::step ◄───────────────── Drive::accept ◄─────────────────┘
//! ```
//!
//! The law commands engine torque ([`Output::torque`](crate::law::Output::torque)); the accelerations
//! that go with it are in the output as well, so that the gateway has a future to follow.

mod limiter;
mod preview;
mod prices;
pub mod route;

pub use preview::{MAX_CELLS, Preview};
pub use prices::Prices;
