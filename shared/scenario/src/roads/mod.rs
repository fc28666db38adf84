//! The tables of the road: its heights and its plan.

pub mod grade;
pub mod plan;
pub mod road;
