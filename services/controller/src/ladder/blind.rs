//! Braking while it is not known what is ahead.
//!
//! A vehicle's rear was last seen at `p` with the speed `v_l`. If it brakes with `b` since then, it comes to
//! stand at `p + v_l²/(2 b)`. To stand `MARGIN_M` behind it the ego, at `x` with the speed `v`, needs
//!
//! ```text
//! d(b) = v² / (2 (p + v_l²/(2 b) - x - MARGIN_M))
//! ```
//!
//! `v_l` is what the radar measured, less what the measurement is late by. The request is the largest of three:
//!
//! * comfortable braking,
//! * `d(b)` for full braking of the lead, up to the deceleration of a minimum risk manoeuvre,
//! * `d(b)` for the braking that was seen, and a share that the lead may still have added.

use super::lead::LastSeen;
use crate::law::Ego;
use crate::law::following::parameters::FOLLOWING;
use crate::law::following::safe_gap::LeadNow;

pub(super) const COMFORTABLE_MPS2: f64 = 2.0;
/// Jerk with which comfortable braking begins, m/s³.
const COMFORTABLE_JERK_MPS3: f64 = 2.5;
/// Jerk with which a minimum risk manoeuvre begins, m/s³.
const MINIMUM_RISK_JERK_MPS3: f64 = 5.0;
/// Jerk with which harder braking begins, m/s³ (UN R157, annex 4, appendix 3).
const HARD_JERK_MPS3: f64 = 12.65;
/// Hardest braking of what was ahead, m/s² (full braking of UN R157's models).
const WORST_MPS2: f64 = 6.0;
/// Deceleration of a minimum risk manoeuvre, m/s² (UN R157, 5.5.1).
const MINIMUM_RISK_MPS2: f64 = 4.0;
/// Braking of a vehicle counts from here on, m/s².
const BRAKES_MPS2: f64 = 1.0;
/// Delay of the measured speed of a vehicle that brakes, s.
const SEEN_LATE_S: f64 = 0.2;
/// Distance that is left at standstill, m.
const MARGIN_M: f64 = 3.0;
/// Least assumed stopping distance, m.
const LEAST_ROOM_M: f64 = 0.5;

/// Deceleration with which the ego comes to stand behind `last` if that brakes with `braking`, m/s².
fn needed_mps2(last: &LastSeen, ego: &Ego, braking: f64) -> f64 {
    let lead = LeadNow {
        gap_m: last.position_m - ego.position_m,
        speed_mps: (last.speed_mps - braking * SEEN_LATE_S).max(0.0),
        acceleration_mps2: -braking,
    };
    0.5 * ego.speed_mps * ego.speed_mps / lead.room_m(MARGIN_M).max(LEAST_ROOM_M)
}

pub(super) fn deceleration_mps2(ego: &Ego, last: Option<&LastSeen>) -> f64 {
    let Some(last) = last else { return COMFORTABLE_MPS2 };
    let worst = needed_mps2(last, ego, WORST_MPS2).min(MINIMUM_RISK_MPS2);
    let seen = last.braking_mps2();
    let as_seen = if seen > BRAKES_MPS2 {
        needed_mps2(last, ego, (1.0 + FOLLOWING.may_add_share) * seen)
    } else {
        0.0
    };
    worst.max(as_seen).max(COMFORTABLE_MPS2)
}

/// Fills a plan that goes from the request `from_mps2` to a deceleration and keeps it.
pub(super) fn fill(plan_mps2: &mut [f64], from_mps2: f64, deceleration: f64, period_s: f64) {
    let jerk = match deceleration {
        d if d <= COMFORTABLE_MPS2 => COMFORTABLE_JERK_MPS3,
        d if d <= MINIMUM_RISK_MPS2 => MINIMUM_RISK_JERK_MPS3,
        _ => HARD_JERK_MPS3,
    };
    let mut request = from_mps2;
    for place in plan_mps2 {
        request = (request - jerk * period_s).max(-deceleration);
        *place = request;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Target;

    const EGO: Ego = Ego { position_m: 0.0, speed_mps: 20.0, acceleration_mps2: 0.0 };

    fn last(position_m: f64, speed_mps: f64, acceleration_mps2: f64) -> LastSeen {
        let target = Target { acceleration_mps2, ..Target::default() };
        LastSeen { target, position_m, speed_mps, time_s: 0.0, since_s: 0.0 }
    }

    #[test]
    fn braking_is_comfortable_where_nothing_was_ahead() {
        assert_eq!(deceleration_mps2(&EGO, None), COMFORTABLE_MPS2);
        assert_eq!(deceleration_mps2(&EGO, Some(&last(200.0, 20.0, 0.0))), COMFORTABLE_MPS2);
    }

    #[test]
    fn behind_a_vehicle_that_may_brake_it_is_as_hard_as_needed_up_to_a_minimum_risk_manoeuvre() {
        // It would stand at 36.4 + 33.3 m: 66.7 m to stop in.
        let needed = deceleration_mps2(&EGO, Some(&last(36.4, 21.2, 0.0)));
        assert!((needed - 3.0).abs() < 0.01, "{needed}");
        assert_eq!(deceleration_mps2(&EGO, Some(&last(10.0, 20.0, 0.0))), MINIMUM_RISK_MPS2);
    }

    #[test]
    fn behind_a_vehicle_that_was_braking_it_is_as_hard_as_that_asks_for() {
        // 1.3 times 8 m/s²: 2.08 m/s less than measured. It would stand at 20 + 20.0 m, with 37.0 m to stop in.
        let harder = deceleration_mps2(&EGO, Some(&last(20.0, 22.476, -8.0)));
        assert!((harder - 200.0 / 37.0).abs() < 0.01, "{harder}");
        // One that brakes gently asks for no more than a minimum risk manoeuvre.
        let gentle = deceleration_mps2(&EGO, Some(&last(20.0, 20.0, -1.5)));
        assert_eq!(gentle, MINIMUM_RISK_MPS2);
    }

    #[test]
    fn a_plan_reaches_its_deceleration_with_the_jerk_of_its_kind() {
        for (deceleration, jerk) in [(2.0, 2.5), (4.0, 5.0), (4.1, 12.65)] {
            let mut plan = [0.0; 40];
            fill(&mut plan, -0.5, deceleration, 0.1);
            assert!((plan[0] + 0.5 + 0.1 * jerk).abs() < 1e-9, "{plan:?}");
            assert_eq!(plan[39], -deceleration);
        }
    }
}
