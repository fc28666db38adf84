//! The requested acceleration of each mode, m/s².

use super::boundaries::Boundaries;
use super::deceleration::level_mps2;
use super::modes::{Mode, Situation};
use super::parameters::{Parameters, Variant};

/// Set-speed error up to which the cruise law is proportional, m/s (1 km/h).
const CRUISE_BAND: f64 = 1.0 / 3.6;
/// Hardest braking of the cruise law.
const CRUISE_BRAKING: f64 = -1.0;
/// Steady mode (1), slightly closing: replaces eq (9). Its k2 is not printed; the paper found its value within -0.08
/// and -0.12.
const STEADY_CLOSING: f64 = -0.1;
/// Steady mode (2), slightly opening: a number of the text, without an equation.
const STEADY_OPENING: f64 = 0.4;

/// Eq (7): reach and keep the set speed. The paper prints `a = k1 V_r`, but no target gives a V_r there. The text
/// speaks of the set speed, so V_set - V_h is meant.
pub(super) fn cruise(p: &Parameters, set_speed: f64, speed: f64) -> f64 {
    let error = set_speed - speed;
    if error > CRUISE_BAND {
        p.largest_mps2()
    } else {
        (p.cruise_gain_per_s * error).clamp(CRUISE_BRAKING, p.largest_mps2())
    }
}

/// Acceleration per deviation from the closing speed, 1/s, and its least value, m/s².
const REGULATE_PER_S: f64 = 0.5;
const REGULATE_LEAST_MPS2: f64 = -1.0;

/// Request of a mode that has a target, before mean and limits.
pub(super) fn following(p: &Parameters, mode: Mode, s: &Situation, b: &Boundaries) -> f64 {
    match mode {
        Mode::Approach if p.regulates() => approach(p, s, b).min(closing_mps2(p, s)),
        Mode::Approach => approach(p, s, b),
        Mode::Steady => steady(p, s, b),
        Mode::Decelerate if p.regulates() => {
            level_mps2(p, s, b).min(steady(p, s, b)).min(closing_mps2(p, s))
        }
        Mode::Decelerate => level_mps2(p, s, b),
        Mode::Avoid => -p.braking_mps2,
        Mode::Accelerate | Mode::Cruise => p.largest_mps2(),
    }
}

/// Time headway left behind a slower target when speeds match, s, and time until a request acts, s.
const LEFT_S: f64 = 1.0;
const ACTS_LATE_S: f64 = 0.5;
/// Least way in which speeds match, m.
const LEAST_WAY_M: f64 = 5.0;

/// The constant deceleration that matches speeds before the gap is used up: begun in time, it stays gentle.
fn closing_mps2(p: &Parameters, s: &Situation) -> f64 {
    let closing_mps = (-s.relative_mps).max(0.0);
    let target_mps = (s.speed_mps + s.relative_mps).max(0.0);
    let way_m = s.gap_m - p.standstill_gap_m - LEFT_S * target_mps - ACTS_LATE_S * closing_mps;
    -closing_mps * closing_mps / (2.0 * way_m.max(LEAST_WAY_M))
}

/// Eq (8): the constant deceleration that matches speeds at R_w. Its minus is not printed: the mode brakes. The literal
/// law divides by what is left of the way, whatever it is (trap 3).
fn approach(p: &Parameters, s: &Situation, b: &Boundaries) -> f64 {
    let way = s.gap_m - b.warning_m;
    let square = s.relative_mps * s.relative_mps;
    match p.variant {
        Variant::Literal if way > 0.0 => -square / (2.0 * way),
        Variant::Literal => f64::NEG_INFINITY,
        Variant::Robust => {
            (-square / (2.0 * way.max(p.approach_floor_m))).max(-p.approach_limit_mps2)
        }
    }
}

/// Steady driving: the numbers beside eq (9), and eq (10). "Speeds very close" is k_c, which is not printed. The robust
/// law lets the push fade towards R_w, which itself grows with the ego's speed. Otherwise steady and decelerate
/// alternate for ever (trap 6).
fn steady(p: &Parameters, s: &Situation, b: &Boundaries) -> f64 {
    let relative = s.relative_mps;
    if p.regulates() {
        let wanted = REGULATE_PER_S * (relative + b.closing_mps(p, s.gap_m));
        return wanted.clamp(REGULATE_LEAST_MPS2, p.acceleration_mps2);
    }
    if relative.abs() < p.steady_band_mps {
        p.steady_gain_per_s * relative
    } else if relative < 0.0 {
        STEADY_CLOSING
    } else {
        match p.variant {
            Variant::Literal => STEADY_OPENING,
            Variant::Robust => {
                STEADY_OPENING * ((s.gap_m - b.warning_m) / p.opening_fade_m).clamp(0.0, 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_mode::Spacing;

    #[test]
    fn cruise_is_the_papers_equation_7() {
        let p = Parameters::published();
        assert_eq!(cruise(&p, 20.0, 19.0), 1.0);
        assert_eq!(cruise(&p, 20.0, 19.75), 0.25);
        assert_eq!(cruise(&p, 20.0, 20.5), -0.5);
        assert_eq!(cruise(&p, 20.0, 30.0), -1.0);
    }

    #[test]
    fn approach_is_equation_8() {
        let s = Situation { gap_m: 130.0, speed_mps: 20.0, relative_mps: -4.0 };
        let b = Boundaries { warning_m: 110.0, ..Boundaries::default() };
        for p in [Parameters::default(), Parameters::literal()] {
            assert_eq!(following(&p, Mode::Approach, &s, &b), -0.4);
        }
    }

    #[test]
    fn steady_follows_the_numbers_beside_equation_9_and_equation_10() {
        let p = Parameters { spacing: Spacing::Paper, ..Parameters::default() };
        let b = Boundaries { warning_m: 40.0, ..Boundaries::default() };
        let at = |p: &Parameters, gap_m, relative_mps| {
            steady(p, &Situation { gap_m, speed_mps: 10.0, relative_mps }, &b)
        };
        assert_eq!(at(&p, 60.0, 0.1), 0.02 * 0.1);
        assert_eq!(at(&p, 60.0, -0.3), -0.1);
        assert_eq!(at(&p, 60.0, 0.3), 0.4);
        assert_eq!(at(&p, 45.0, 0.3), 0.2);
        assert_eq!(at(&Parameters::literal(), 45.0, 0.3), 0.4);
    }
}
