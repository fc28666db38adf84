//! Each transition of the decision, and what holds in all of them.

use super::*;

const PERIOD_S: f64 = 0.05;

fn settings() -> Settings {
    Settings {
        authority: Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 },
        horizon_s: 3.0,
        period_s: PERIOD_S,
        margin_m: 0.6,
        warning_s: 0.8,
        ego_length_m: 4.5,
    }
}

/// Takes a scan, and once more if it asks for braking: two scans must.
fn step<const N: usize>(decision: &mut Decision, ego: &Ego, objects: [Object; N]) -> Demand {
    let demand = decision.step(ego, objects);
    let waits = decision.asks && demand.deceleration_mps2 == 0.0;
    if waits { decision.step(ego, objects) } else { demand }
}

/// Drives at `speed` towards something of `other` m/s at `gap`. Returns each state with its time,
/// and the last gap.
fn drive(speed: f64, other: f64, gap: f64) -> (Vec<(f64, BrakeState)>, f64) {
    let mut decision = Decision::new(settings());
    let (mut v, mut a, mut d, mut asked_s) = (speed, 0.0_f64, gap, 0.0);
    let mut states = Vec::new();
    for k in 0..2000 {
        let t = f64::from(k) * 0.01;
        if k % 5 == 0 {
            let object = Object::at(d, other, 0.0, 0.0);
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
    let object = Object::at(40.0, 0.0, 0.0, 0.0);
    let demand = step(&mut decision, &ego, [object]);
    assert_eq!(demand.state, BrakeState::Monitoring);
}

#[test]
fn a_stop_behind_a_standing_car_at_walking_pace_is_left_alone() {
    let mut decision = Decision::new(settings());
    for gap in [3.0, 2.0, 1.5] {
        let ego = Ego { speed_mps: 0.8, acceleration_mps2: -0.5 };
        let object = Object::at(gap, 0.0, 0.0, 0.0);
        let demand = step(&mut decision, &ego, [object]);
        assert_eq!(demand.state, BrakeState::Monitoring, "{gap} m");
    }
}

#[test]
fn a_stop_just_behind_what_seems_to_creep_backwards_is_left_alone() {
    let state = |other_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 1.19, acceleration_mps2: -3.24 };
        step(&mut decision, &ego, [Object::at(0.47, other_mps, 0.0, 0.0)]).state
    };
    assert_eq!(state(-0.03), BrakeState::Monitoring, "noise of a range rate");
    assert_ne!(state(-0.5), BrakeState::Monitoring, "it comes");
}

#[test]
fn an_oncoming_vehicle_is_braked_for_when_waiting_would_cost_speed() {
    let state = |gap_m: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 13.0, acceleration_mps2: 0.0 };
        step(&mut decision, &ego, [Object::at(gap_m, -7.0, 0.0, 0.0)]).state
    };
    // 13 m/s take some 2 s. In this time 20 m/s of closing speed cover less than 35 m.
    assert_eq!(state(80.0), BrakeState::Monitoring, "it may turn off");
    assert_eq!(state(20.0), BrakeState::Braking, "each cycle costs speed");
}

#[test]
fn an_object_passed_before_it_comes_in_is_left_alone() {
    let brakes = |gap_m: f64, lateral_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };
        let object = Object::at(gap_m, 5.0, 3.4, -lateral_mps);
        step(&mut decision, &ego, [object]).state == BrakeState::Braking
    };
    // The way of 5 + 8.8 m takes 0.92 s at 15 m/s. The 1.5 m to the ego's side take 1.5 s or 0.8 s.
    assert!(!brakes(5.0, 1.0));
    assert!(brakes(5.0, 1.9));
    // 18 m at 15 m/s: it is in the way when the ego arrives, and this is the last point.
    assert!(brakes(18.0, 1.0));
    assert!(!brakes(40.0, 1.0), "later will do");
}

#[test]
fn a_pass_that_braking_would_turn_into_a_contact_is_not_braked_for() {
    let brakes = |distance_m: f64, lateral_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 25.0, acceleration_mps2: 0.0 };
        let object = Object::at(distance_m, 5.0, 3.5, -lateral_mps);
        step(&mut decision, &ego, [object]).state == BrakeState::Braking
    };
    // It is in the way after 1.6 s; the pass takes 1.44 s or, from farther off, longer.
    assert!(!brakes(20.0, 1.0));
    assert!(brakes(27.0, 1.0));
}

#[test]
fn an_uncertain_object_is_braked_for_when_a_contact_is_likely() {
    let contact = |sigma_m: f64| {
        let decision = Decision::new(settings());
        let mut object = Object::at(20.0, 5.0, 3.5, -0.4);
        object.lateral = crate::filter::Lateral::first(3.0, sigma_m);
        let beside = Beside { first_s: 1.0, last_s: 2.0, first_mps: 10.0 };
        decision.contact(&object, Some(beside)).probability
    };
    assert!(contact(0.05) < 0.2 && contact(0.05) > 0.0);
    assert!(contact(1.0) > contact(0.05), "where it is may be in the way");
}

const STANDING: Ego = Ego { speed_mps: 0.0, acceleration_mps2: 0.0 };
const MOVING: Ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };

fn in_way(gap_m: f64, speed_mps: f64) -> Object {
    Object::at(gap_m, speed_mps, 0.0, 0.0)
}

/// A decision that brakes already.
fn braking() -> Decision {
    let mut decision = Decision::new(settings());
    step(&mut decision, &MOVING, [in_way(15.0, 0.0)]);
    assert_eq!(decision.state, BrakeState::Braking);
    decision
}

#[test]
fn it_holds_for_its_time_after_a_stop_and_lets_go_then() {
    let mut decision = braking();
    let demand = step(&mut decision, &STANDING, [in_way(2.0, 0.0)]);
    assert_eq!((demand.state, demand.deceleration_mps2), (BrakeState::Holding, 8.3385));
    let scans = (HOLD_S / PERIOD_S).round() as u32;
    for scan in 1..scans {
        let demand = step(&mut decision, &STANDING, [in_way(2.0, 0.0)]);
        assert_eq!(demand.state, BrakeState::Holding, "scan {scan}");
        assert!(demand.deceleration_mps2 > 0.0);
    }
    let states = [(); 3].map(|()| step(&mut decision, &STANDING, [in_way(2.0, 0.0)]).state);
    assert_eq!(states[2], BrakeState::Monitoring, "{states:?}");
}

#[test]
fn it_holds_without_an_object_too() {
    let mut decision = braking();
    assert_eq!(step(&mut decision, &STANDING, []).state, BrakeState::Holding);
    assert_eq!(step(&mut decision, &STANDING, []).state, BrakeState::Holding);
}

#[test]
fn an_unseen_threat_is_braked_for_during_its_time_alone() {
    let mut decision = braking();
    let scans = (UNSEEN_S / PERIOD_S).round() as u32;
    for scan in 1..scans {
        assert_eq!(step(&mut decision, &MOVING, []).state, BrakeState::Braking, "scan {scan}");
    }
    let states = [(); 2].map(|()| step(&mut decision, &MOVING, []).state);
    assert_eq!(states[1], BrakeState::Monitoring, "{states:?}");
    // Seen again in between, the time begins anew.
    let mut decision = braking();
    for _ in 0..3 * scans {
        step(&mut decision, &MOVING, []);
        let again = step(&mut decision, &MOVING, [in_way(12.0, 0.0)]);
        assert_eq!(again.state, BrakeState::Braking);
    }
}

#[test]
fn it_lets_go_of_a_lead_that_is_faster_but_not_of_a_near_one_that_brakes_on() {
    let lets_go = |gap_m: f64, acceleration_mps2: f64| {
        let mut decision = braking();
        let lead = Object { acceleration_mps2, ..in_way(gap_m, 20.5) };
        // An object that is of no interest is braked for as long as one that is not seen.
        for _ in 0..9 {
            step(&mut decision, &MOVING, [lead]);
        }
        decision.state == BrakeState::Monitoring
    };
    assert!(lets_go(30.0, 0.0));
    assert!(lets_go(4.0, 0.0), "a steady lead that is no slower");
    assert!(!lets_go(4.0, -6.0), "it brakes on");
}

#[test]
fn close_behind_a_slower_car_a_reserve_is_kept_for_its_braking() {
    let state = |gap_m: f64, other_mps: f64| {
        let mut decision = Decision::new(settings());
        step(&mut decision, &MOVING, [in_way(gap_m, other_mps)]).state
    };
    // 6 m/s faster: 2.5 m/s² need 7.2 m and what their onset takes, 6 m/s² 3 m and the same.
    assert_eq!(state(7.0, 14.0), BrakeState::Braking, "it may brake");
    assert_ne!(state(12.0, 14.0), BrakeState::Braking, "a driver can still answer");
    // A standing object cannot begin to brake.
    assert_ne!(state(36.0, 0.0), BrakeState::Braking);
}

#[test]
fn a_warning_comes_first_and_ends_with_its_threat() {
    let mut decision = Decision::new(settings());
    let far = step(&mut decision, &MOVING, [in_way(45.0, 0.0)]);
    assert_eq!((far.state, far.deceleration_mps2), (BrakeState::Warning, 0.0));
    assert_eq!(far.threat.map(|threat| threat.0), Some(45.0));
    assert_eq!(step(&mut decision, &MOVING, []).state, BrakeState::Monitoring);
    assert_eq!(step(&mut decision, &MOVING, [in_way(300.0, 0.0)]).threat, None);
}

#[test]
fn a_vehicle_that_comes_in_is_not_expected_to_brake_as_well_and_a_lead_is() {
    // 18 m/s faster. With the whole authority that is 19 m and the onset. A lead that also brakes needs much more.
    let first_braking_m = |offset_m: f64, inward_mps: f64| {
        let mut decision = Decision::new(settings());
        let ego = Ego { speed_mps: 25.0, acceleration_mps2: 0.0 };
        (0..1600).map(|k| 80.0 - 0.05 * f64::from(k)).find(|gap_m| {
            let object = Object::at(*gap_m, 7.0, offset_m, -inward_mps);
            step(&mut decision, &ego, [object]).state == BrakeState::Braking
        })
    };
    let lead_m = first_braking_m(0.0, 0.0).expect("it brakes for a lead");
    let beside_m = first_braking_m(2.6, 1.0).expect("it brakes for what comes in");
    assert!(lead_m > beside_m + 4.0, "{lead_m} {beside_m}");
    assert!(beside_m > 27.0, "{beside_m}");
}

#[test]
fn after_holding_it_warns_or_monitors_and_holds_on_while_it_would_brake() {
    let after = |object: Object| {
        let mut decision = braking();
        step(&mut decision, &STANDING, []);
        let scans = (HOLD_S / PERIOD_S).round() as u32;
        for _ in 0..=scans {
            step(&mut decision, &MOVING, [object]);
        }
        decision.state
    };
    assert_eq!(after(in_way(15.0, 0.0)), BrakeState::Holding);
    assert_eq!(after(in_way(45.0, 0.0)), BrakeState::Warning);
    assert_eq!(after(in_way(300.0, 0.0)), BrakeState::Monitoring);
}

#[test]
fn a_warning_becomes_braking_and_braking_never_a_warning() {
    let mut decision = Decision::new(settings());
    let states: Vec<BrakeState> = (0..40)
        .map(|k| step(&mut decision, &MOVING, [in_way(60.0 - f64::from(k), 0.0)]).state)
        .collect();
    let changes: Vec<_> = states.windows(2).filter(|pair| pair[0] != pair[1]).collect();
    assert_eq!(changes.len(), 2, "{states:?}");
    assert_eq!(changes[0], [BrakeState::Monitoring, BrakeState::Warning]);
    assert_eq!(changes[1], [BrakeState::Warning, BrakeState::Braking]);
    // The car ahead drives away.
    for _ in 0..9 {
        step(&mut decision, &MOVING, [in_way(60.0, 25.0)]);
    }
    assert_eq!(decision.state, BrakeState::Monitoring);
}

proptest::proptest! {
    #[test]
    fn it_never_begins_to_brake_without_an_object(speeds in proptest::collection::vec(0.0..60.0f64, 1..60)) {
        let mut decision = Decision::new(settings());
        for speed_mps in speeds {
            let demand = step(&mut decision, &Ego { speed_mps, acceleration_mps2: -1.0 }, []);
            proptest::prop_assert_eq!(demand, Demand::default());
        }
    }

    #[test]
    fn it_never_lets_go_below_the_margin_of_what_is_slower(
        gap_m in 0.0..0.6f64, other_mps in 0.0..19.0f64, braking_mps2 in 0.0..8.0f64,
    ) {
        let mut decision = braking();
        for _ in 0..4 {
            let object = Object { acceleration_mps2: -braking_mps2, ..in_way(gap_m, other_mps) };
            let demand = step(&mut decision, &MOVING, [object]);
            proptest::prop_assert_eq!(demand.state, BrakeState::Braking);
            proptest::prop_assert!(demand.deceleration_mps2 > 8.0);
        }
    }

    #[test]
    fn it_holds_at_standstill_whatever_is_there(
        gap_m in 0.0..100.0f64, other_mps in 0.0..30.0f64, offset_m in -4.0..4.0f64, scans in 0..19,
    ) {
        let mut decision = braking();
        for _ in 0..=scans {
            let object = Object::at(gap_m, other_mps, offset_m, 0.0);
            let demand = step(&mut decision, &STANDING, [object]);
            proptest::prop_assert_eq!(demand.state, BrakeState::Holding);
            proptest::prop_assert_eq!(demand.deceleration_mps2, 8.3385);
        }
    }

    #[test]
    fn it_never_brakes_for_what_drives_away(gap_m in 2.0..100.0f64, faster_mps in 0.5..20.0f64) {
        let mut decision = Decision::new(settings());
        let demand = step(&mut decision, &MOVING, [in_way(gap_m, 20.0 + faster_mps)]);
        proptest::prop_assert_eq!(demand.state, BrakeState::Monitoring);
    }
}

#[test]
fn a_road_that_may_bend_makes_a_contact_less_sure() {
    let decision = Decision::new(settings());
    let probability = |offset_m: f64, way_sigma_m: f64| {
        let object = Object { way_sigma_m, ..Object::at(60.0, 0.0, offset_m, 0.0) };
        let threat = Threat { gap_m: 60.0, speed_mps: 0.0, acceleration_mps2: 0.0, passed_m: 9.0 };
        let beside = settings().authority.beside(&MOVING, &threat, NEVER_S, 0.0);
        decision.contact(&object, beside).probability
    };
    assert!(probability(0.0, 0.0) > probability(0.0, 1.2));
    assert!(probability(3.5, 0.0) < probability(3.5, 1.2));
}

#[test]
fn the_costs_of_both_mistakes_are_equal_at_the_limit() {
    for closing_mps in [0.0, 4.3, 12.0, 30.0] {
        let p = likely(closing_mps);
        let contact = p * (CONTACT_COST_MPS + closing_mps);
        let braking = (1.0 - p) * (CONTACT_COST_MPS + FALSE_COST_MPS);
        assert!((contact - braking).abs() < 1e-9, "{closing_mps}");
    }
    assert_eq!(likely(-5.0), likely(0.0));
}
