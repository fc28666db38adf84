//! The tables of the road: its heights and its plan.

pub mod plan;
pub mod road;
