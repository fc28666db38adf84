//! Each transition of the decision, and what holds in all of them.

use super::*;

const PERIOD_S: f64 = 0.05;

fn settings() -> Settings {
    Settings {
        authority: Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 },
        path: Path { half_width_m: 0.95, horizon_s: 3.0 },
        period_s: PERIOD_S,
        margin_m: 0.6,
        warning_s: 0.8,
        ego_length_m: 4.5,
    }
}

/// Drives at `speed` towards something of `other` m/s at `gap`; returns the states with the times
/// at which they were entered and the last gap.
fn drive(speed: f64, other: f64, gap: f64) -> (Vec<(f64, BrakeState)>, f64) {
    let mut decision = Decision::new(settings());
    let (mut v, mut a, mut d, mut asked_s) = (speed, 0.0_f64, gap, 0.0);
    let mut states = Vec::new();
    for k in 0..2000 {
        let t = f64::from(k) * 0.01;
        if k % 5 == 0 {
            let object = Object::at(d, other, 0.0, 0.0, 0.95);
            let ego = Ego { speed_mps: v, acceleration_mps2: a };
            let demand = decision.step(&ego, [object]);
            if states.last().is_none_or(|last: &(f64, BrakeState)| last.1 != demand.state) {
                states.push((t, demand.state));
            }
            asked_s = if demand.deceleration_mps2 > 0.0 { asked_s + 0.05 } else { 0.0 };
        }
        a = if asked_s > 0.1 { (a - 0.1265).max(-8.3385) } else { (a + 0.1265).min(0.0) };
        let next = (v + a * 0.01).max(0.0);
        d += 0.01 * (other - 0.5 * (v + next));
        v = next;
    }
    (states, d)
}

#[test]
fn it_warns_then_brakes_then_holds_short_of_what_stands() {
    let (states, gap) = drive(20.0, 0.0, 100.0);
    let order: Vec<BrakeState> = states.iter().map(|(_, state)| *state).collect();
    let expected =
        [BrakeState::Monitoring, BrakeState::Warning, BrakeState::Braking, BrakeState::Holding];
    assert_eq!(order[..4], expected, "{states:?}");
    assert!(states[2].0 - states[1].0 >= 0.75, "{states:?}");
    assert!((0.0..2.0).contains(&gap), "it stops at {gap} m");
}

#[test]
fn it_lets_go_once_the_other_is_faster() {
    let (states, gap) = drive(30.0, 15.0, 80.0);
    assert!(states.iter().any(|(_, state)| *state == BrakeState::Braking), "{states:?}");
    assert_eq!(states.last().map(|last| last.1), Some(BrakeState::Monitoring), "{states:?}");
    assert!(gap > 0.0);
}

#[test]
fn an_ego_that_brakes_enough_by_itself_is_left_alone() {
    let mut decision = Decision::new(settings());
    // 20 m/s needs 5 m/s² in 40 m.
    let ego = Ego { speed_mps: 20.0, acceleration_mps2: -5.2 };
    let object = Object::at(40.0, 0.0, 0.0, 0.0, 0.95);
    let demand = decision.step(&ego, [object]);
    assert_eq!(demand.state, BrakeState::Monitoring);
}

#[test]
fn a_stop_behind_a_standing_car_at_walking_pace_is_left_alone() {
    let mut decision = Decision::new(settings());
    for gap in [3.0, 2.0, 1.5] {
        let ego = Ego { speed_mps: 0.8, acceleration_mps2: -0.5 };
        let object = Object::at(gap, 0.0, 0.0, 0.0, 0.95);
        let demand = decision.step(&ego, [object]);
        assert_eq!(demand.state, BrakeState::Monitoring, "{gap} m");
    }
}

#[test]
fn what_is_passed_before_it_comes_in_is_left_alone() {
    let brakes = |gap_m: f64, lateral_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };
        let object = Object::at(gap_m, 5.0, 3.4, -lateral_mps, 0.95);
        decision.step(&ego, [object]).state == BrakeState::Braking
    };
    // 5 + 8.8 m at 15 m/s take 0.92 s, the 1.5 m to the ego's side 1.5 s or 0.8 s.
    assert!(!brakes(5.0, 1.0));
    assert!(brakes(5.0, 1.9));
    // 18 m at 15 m/s: it is in the way when the ego is there, and this is the last point.
    assert!(brakes(18.0, 1.0));
    assert!(!brakes(40.0, 1.0), "later will do");
}

#[test]
fn a_pass_that_braking_would_turn_into_a_contact_is_not_braked_for() {
    let brakes = |distance_m: f64, lateral_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 25.0, acceleration_mps2: 0.0 };
        let object = Object::at(distance_m, 5.0, 3.5, -lateral_mps, 0.95);
        decision.step(&ego, [object]).state == BrakeState::Braking
    };
    // It is in the way after 1.6 s; the pass takes 1.44 s or, from farther off, longer.
    assert!(!brakes(20.0, 1.0));
    assert!(brakes(27.0, 1.0));
}

#[test]
fn what_is_known_vaguely_is_braked_for_when_a_contact_is_likely() {
    let contact = |sigma_m: f64| {
        let decision = Decision::new(settings());
        let mut object = Object::at(20.0, 5.0, 3.5, -0.4, 0.95);
        object.lateral = crate::filter::Lateral::first(3.0, sigma_m);
        let beside = Beside { first_s: 1.0, last_s: 2.0, first_mps: 10.0, last_mps: 10.0 };
        decision.contact(&object, &beside).probability
    };
    assert!(contact(0.05) < 0.2 && contact(0.05) > 0.0);
    assert!(contact(1.0) > contact(0.05), "where it is may be in the way");
}
