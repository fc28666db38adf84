//! Modes, reasons and figures of the law.

use law::{Figure, Formulation};

/// The meaning of the numbers in the output of a certified design.
pub static CERTIFIED: Formulation = Formulation {
    name: "quadratic boundedness",
    caution: None,
    modes: &["cruise", "follow", "fall-back"],
    reasons: &reasons("outside the certified range"),
    figures: &figures(Figure::new("lyapunov", "1"), "the same within the certified range"),
};

/// The same for the printed gains.
pub static PRINTED: Formulation = Formulation {
    name: "quadratic boundedness, gains as printed",
    caution: Some("uncertified"),
    modes: CERTIFIED.modes,
    reasons: &reasons("beyond comfortable braking"),
    figures: &figures(
        Figure::new("urgency", "1").meaning("needed over comfortable deceleration"),
        "the same, cut off above",
    ),
};

const fn reasons(of_fall_back: &'static str) -> [&'static str; 5] {
    ["none", "no target in range", "set speed demands less", "lead demands less", of_fall_back]
}

/// The figures, of which the first ends the law's range at 1; `used` says how the gap error is cut off.
const fn figures(excess: Figure, used: &'static str) -> [Figure; 8] {
    [
        excess,
        Figure::new("gap_error_m", "m").meaning("real minus desired gap; negative: too close"),
        Figure::new("gap_error_used_m", "m").meaning(used),
        Figure::new("speed_error_mps", "m/s").meaning("target's speed minus speed"),
        Figure::new("gap_error_rate_mps", "m/s"),
        Figure::new("increment_mps2", "m/s²"),
        Figure::new("cruise_increment_mps2", "m/s²"),
        Figure::new("follow_increment_mps2", "m/s²"),
    ]
}
