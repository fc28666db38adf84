//! Modes, reasons and figures of the law, and their places in the lists.

use crate::law::{Figure, Formulation};

/// The meaning of the numbers in the output.
pub static FORMULATION: Formulation = Formulation {
    name: "truck",
    caution: None,
    modes: &["cruise", "predictive", "follow", "warn"],
    reasons: &[
        "none",
        "plan",
        "no_plan",
        "map_contradicts",
        "target",
        "target_gone",
        "too_close",
        "bad_input",
    ],
    figures: &[
        Figure::new("economic_speed_mps", "m/s"),
        Figure::new("engine_torque_nm", "N m"),
        Figure::new("gear", "1"),
        Figure::new("time_price", "1"),
        Figure::new("lag_s", "s"),
        Figure::new("filtered_gap_m", "m"),
        Figure::new("service_brake_n", "N"),
        Figure::new("plan_ahead_m", "m"),
    ],
};

pub const CRUISE: u32 = 0;
pub const PREDICTIVE: u32 = 1;
pub const FOLLOW: u32 = 2;
pub const WARN: u32 = 3;
pub const PLAN: u32 = 1;
pub const NO_PLAN: u32 = 2;
pub const MAP_CONTRADICTS: u32 = 3;
pub const TARGET: u32 = 4;
pub const TARGET_GONE: u32 = 5;
pub const TOO_CLOSE: u32 = 6;
pub const BAD_INPUT: u32 = 7;
