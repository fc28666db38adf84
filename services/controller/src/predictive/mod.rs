//! Predictive cruise for a heavy truck (Li, Zheng, Wang, Wang; FAW Jiefang JH6).
//!
//! Planning and driving are apart, so that planning can go on beside the control loop, at any latency:
//!
//! ```text
//!   Input ──► Predictive::step ──► Output
//!                ▲       │ Planning::request
//!                │       ▼
//!                │   PlanRequest ──► Planner::plan ──► Plan
//!                │                                      │
//!                └──────── Planning::accept ◄───────────┘
//! ```
//!
//! The law commands engine torque ([`Output::torque`](crate::law::Output::torque)); the accelerations
//! that go with it are in the output as well, so that the gateway has a future to follow.
//!
//! | part | of the paper | module |
//! |---|---|---|
//! | road classes, reconstruction | steps 1, 2 | `road_classes` |
//! | rolling optimisation, n = 2 | steps 3 to 6 | `paper_n2` |
//! | dynamic programming | the better planner | `dynamic_programming`, `energy_grid` |
//! | servo of the mean speed | beta | `time_price` |
//! | gap, modes | (14) to (16) | `spacing` |
//! | accelerations, brakes | (17), (18) | `following` |
//! | radar filter | | `target_filter` |
//! | whole trips, baselines, the bound | the tables | [`route`] |

mod dynamic_programming;
mod energy_grid;
mod following;
mod gear_curve;
mod law;
mod limiter;
mod map_trust;
mod paper_n2;
mod planner;
mod preview;
mod prices;
mod road_classes;
pub mod route;
mod settings;
mod spacing;
mod speed_keeper;
mod target_filter;
mod time_price;
mod tracking;

pub use dynamic_programming::{DynamicProgramming, Resolution};
pub use law::Predictive;
pub use paper_n2::PaperN2;
pub use planner::{MAX_SEGMENTS, Plan, PlanRequest, Planner, Segment};
pub use preview::{MAX_CELLS, Preview};
pub use prices::Prices;
pub use settings::{PlannerKind, Settings};
