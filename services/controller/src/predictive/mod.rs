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

mod dynamic_programming;
mod energy_grid;
mod limiter;
mod paper_n2;
mod planner;
mod preview;
mod prices;
mod road_classes;
pub mod route;

pub use dynamic_programming::{DynamicProgramming, Resolution};
pub use paper_n2::PaperN2;
pub use planner::{MAX_SEGMENTS, Plan, PlanRequest, Planner, Segment};
pub use preview::{MAX_CELLS, Preview};
pub use prices::Prices;
