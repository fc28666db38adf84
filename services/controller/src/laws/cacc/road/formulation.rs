//! Modes, reasons and figures of the formulation.

use super::decision::Reason;
use crate::law::{Figure, Formulation};

/// The meaning of the numbers in the output.
pub static FORMULATION: Formulation = Formulation {
    name: "road",
    caution: None,
    modes: &["cruise", "follow", "pass", "stop"],
    reasons: &[
        "start",
        "target-lost",
        "target-found",
        "green-in-reach",
        "green-out-of-reach",
        "stop-cheaper",
        "clears-in-yellow",
        "emergency",
        "signal-unknown",
    ],
    figures: &[
        Figure::new("gap_error_m", "m").meaning("desired minus real gap; positive: too close"),
        Figure::new("speed_error_mps", "m/s").meaning("speed minus the target's"),
        Figure::new("filter_correction_mps2", "m/s²"),
        Figure::new("solver_residual", "1"),
        Figure::new("pass_shortfall_m", "m"),
        Figure::new("pass_cost", "1"),
        Figure::new("stop_cost", "1"),
    ],
};

/// Place of `reason` in the list of reasons.
pub fn reason_index(reason: Reason) -> u32 {
    match reason {
        Reason::GreenInReach => 3,
        Reason::GreenOutOfReach => 4,
        Reason::StopCheaper => 5,
        Reason::ClearsInYellow => 6,
        Reason::Emergency => 7,
        Reason::Unknown => 8,
    }
}
