//! Modes, reasons and figures of the law.

use law::{Figure, Formulation};

/// The meaning of the numbers in the output of a certified design.
pub static CERTIFIED: Formulation = Formulation {
    name: "quadratic boundedness",
    caution: None,
    modes: &["cruise", "follow", "fall-back"],
    reasons: &[
        "none",
        "no target in range",
        "set speed demands less",
        "lead demands less",
        "outside the certified range",
    ],
    figures: &[
        Figure::new("lyapunov", "1"),
        Figure::new("gap_error_m", "m").meaning("real minus desired gap; negative: too close"),
        Figure::new("gap_error_used_m", "m").meaning("the same within the certified range"),
        Figure::new("speed_error_mps", "m/s").meaning("target's speed minus speed"),
        Figure::new("gap_error_rate_mps", "m/s"),
        Figure::new("increment_mps2", "m/s²"),
        Figure::new("cruise_increment_mps2", "m/s²"),
        Figure::new("follow_increment_mps2", "m/s²"),
    ],
};

/// The same for the printed gains.
pub static PRINTED: Formulation = Formulation {
    name: "quadratic boundedness, gains as printed",
    caution: Some("uncertified"),
    modes: CERTIFIED.modes,
    reasons: &[
        "none",
        "no target in range",
        "set speed demands less",
        "lead demands less",
        "beyond comfortable braking",
    ],
    figures: &[
        Figure::new("urgency", "1").meaning("needed over comfortable deceleration"),
        Figure::new("gap_error_m", "m").meaning("real minus desired gap; negative: too close"),
        Figure::new("gap_error_used_m", "m").meaning("the same, cut off above"),
        Figure::new("speed_error_mps", "m/s").meaning("target's speed minus speed"),
        Figure::new("gap_error_rate_mps", "m/s"),
        Figure::new("increment_mps2", "m/s²"),
        Figure::new("cruise_increment_mps2", "m/s²"),
        Figure::new("follow_increment_mps2", "m/s²"),
    ],
};
