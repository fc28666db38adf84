//! The modes, and when the law changes between them.

use super::boundaries::Boundaries;
use super::parameters::{Parameters, Spacing};

/// The paper's six modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// 1: no target, keep the set speed.
    Cruise,
    /// 2: closing from afar, brake by eq (8).
    Approach,
    /// 3: about equal speeds, small corrections.
    Steady,
    /// 4: too close, brake in eight levels.
    Decelerate,
    /// 5: danger, brake fully.
    Avoid,
    /// 6: the target runs away, accelerate.
    Accelerate,
}

impl Mode {
    /// Names, in the order of the paper's numbers.
    pub const NAMES: &[&str] =
        &["cruise", "approach", "steady", "decelerate", "avoid", "accelerate"];
}

/// Reason why the law is in its mode: what was true when it entered it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reason {
    /// Nothing decided yet.
    #[default]
    None,
    /// No target within the sensor's range.
    NoTarget,
    /// Gap at or below R_b.
    GapBelowBraking,
    /// Gap below R_w, above R_b.
    GapBelowWarning,
    /// Gap above R_w and closing faster than k.
    ClosingFast,
    /// Gap above R_j and opening.
    GapAboveFollowing,
    /// The other conditions do not hold.
    SpeedsMatched,
    /// The target brakes so hard that what is asked for would leave too little room.
    TargetBraking,
}

impl Reason {
    pub const NAMES: &[&str] = &[
        "none",
        "no target in range",
        "gap below R_b",
        "gap below R_w",
        "closing faster than k",
        "gap above R_j and opening",
        "speeds matched",
        "target brakes hard",
    ];
}

/// Knowledge of the target at one release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Situation {
    /// R: gap, m.
    pub gap_m: f64,
    /// V_h: ego speed, m/s.
    pub speed_mps: f64,
    /// V_r = V_p - V_h, m/s; negative when closing.
    pub relative_mps: f64,
}

/// The paper's table of modes. It has no row for V_r = 0 (trap 5): `None` there.
pub(super) fn literal(p: &Parameters, s: &Situation, b: &Boundaries) -> Option<(Mode, Reason)> {
    if s.relative_mps == 0.0 {
        return None;
    }
    Some(if s.gap_m <= b.braking_m {
        (Mode::Avoid, Reason::GapBelowBraking)
    } else if s.gap_m < b.warning_m {
        (Mode::Decelerate, Reason::GapBelowWarning)
    } else if -s.relative_mps >= p.approach_threshold_mps {
        (Mode::Approach, Reason::ClosingFast)
    } else if s.relative_mps > 0.0 && s.gap_m >= b.following_m {
        (Mode::Accelerate, Reason::GapAboveFollowing)
    } else {
        (Mode::Steady, Reason::SpeedsMatched)
    })
}

/// The same table with hysteresis on every boundary and a dwell between the harmless modes.
///
/// `mode` is the present mode, `held_s` the time since it was entered.
pub(super) fn robust(
    p: &Parameters,
    mode: Option<Mode>,
    held_s: f64,
    s: &Situation,
    b: &Boundaries,
) -> (Mode, Reason) {
    let when = |m: Mode, hysteresis: f64| if mode == Some(m) { hysteresis } else { 0.0 };
    if s.gap_m <= b.braking_m + when(Mode::Avoid, p.braking_hysteresis_m) {
        return (Mode::Avoid, Reason::GapBelowBraking);
    }
    if s.gap_m < b.warning_m + when(Mode::Decelerate, p.warning_hysteresis_m) {
        return (Mode::Decelerate, Reason::GapBelowWarning);
    }
    // Steady driving corrects this itself: it is not an approach.
    let regulated = match p.spacing {
        Spacing::Paper => 0.0,
        Spacing::TimeGap => b.closing_mps(p, s.gap_m).max(0.0),
    };
    let closing_limit = regulated + p.approach_threshold_mps + p.threshold_hysteresis_mps
        - when(Mode::Approach, 2.0 * p.threshold_hysteresis_mps);
    let opening_limit = p.sign_band_mps - when(Mode::Accelerate, 2.0 * p.sign_band_mps);
    let following = b.following_m - when(Mode::Accelerate, p.following_hysteresis_m);
    let next = if -s.relative_mps >= closing_limit {
        (Mode::Approach, Reason::ClosingFast)
    } else if s.relative_mps > opening_limit && s.gap_m >= following {
        (Mode::Accelerate, Reason::GapAboveFollowing)
    } else {
        (Mode::Steady, Reason::SpeedsMatched)
    };
    match mode {
        Some(held) if held_s < p.dwell_s => (held, next.1),
        _ => next,
    }
}

/// True if a target at `gap_m` counts as being within the sensor's range.
pub(super) fn in_range(p: &Parameters, mode: Option<Mode>, gap_m: f64, hysteresis: bool) -> bool {
    let taking_up = hysteresis && mode == Some(Mode::Cruise);
    let margin = if taking_up { p.range_hysteresis_m } else { 0.0 };
    gap_m <= p.sensor_range_m - margin
}
