//! The model-predictive laws `acc-mpc` and `cacc-mpc` (He, Xi, Huang, Chen and Huang, 2024,
//! doi 10.3969/j.issn.2095-1469.2024.06.06).
//!
//! `acc-mpc` follows and ignores signals, `cacc-mpc` uses them. The spacing policy picks the formulation. The paper's
//! own ([`paper`]) reproduces its figures. The one for the road ([`road`]) is the default.

pub mod config;
mod descriptors;
pub mod paper;
mod plan;
pub mod road;
pub mod road_config;
pub mod weights;

pub use config::Signals;
pub use descriptors::{ACC_MPC, BuildError, CACC_MPC, build};
pub(super) use descriptors::{desired_gap, in_scenario};
