use proptest::prelude::*;
use scenario::quantity::{JerkMagnitude, PeriodMs};

use super::*;

const STEP_NS: u64 = 100_000_000;
const PERIOD_NS: u64 = 10_000_000;

/// A gateway whose rates do not bind.
fn gateway() -> Gateway {
    let mut plant = Plant::default();
    plant.gateway.max_rise_mps3 = JerkMagnitude::of(1000.0);
    plant.gateway.max_fall_mps3 = JerkMagnitude::of(1000.0);
    plant.period_ms = PeriodMs::of(100);
    Gateway::new(&plant)
}

fn at(gateway: &mut Gateway, now_ns: u64) -> (f64, Source) {
    let actuation = gateway.actuate(now_ns);
    (actuation.request_mps2, actuation.source)
}

#[test]
fn the_ladder_is_gone_down_by_time_and_up_by_a_command() {
    let mut gateway = gateway();
    assert_eq!(at(&mut gateway, 0), (0.0, Source::None));
    let plan = [1.0, 0.5, -0.5, -1.0];
    assert!(gateway.accept(0, 0, STEP_NS, &plan, None));
    assert_eq!(at(&mut gateway, 0), (1.0, Source::Command));
    assert_eq!(at(&mut gateway, STEP_NS - 1), (1.0, Source::Command));
    assert_eq!(at(&mut gateway, STEP_NS), (0.5, Source::Plan));
    assert_eq!(at(&mut gateway, 3 * STEP_NS), (-1.0, Source::Plan));
    assert_eq!(at(&mut gateway, 9 * STEP_NS), (-1.0, Source::Plan));
    assert_eq!(at(&mut gateway, 11 * STEP_NS), (-1.0, Source::Plan));
    assert_eq!(at(&mut gateway, 11 * STEP_NS + 1), (-2.5, Source::StopInLane));
    let now = 12 * STEP_NS;
    assert!(gateway.accept(now, now, STEP_NS, &[0.7], None));
    assert_eq!(at(&mut gateway, now), (0.7, Source::Command));
}

#[test]
fn a_torque_is_bounded_in_range_and_rate_and_acts_only_while_its_command_is_fresh() {
    let mut gateway = gateway();
    gateway.engine_gives(500.0);
    let asked = Demand { engine_torque_nm: 9e3, service_brake_n: 0.0, gear: Some(5) };
    assert!(gateway.accept(0, 0, STEP_NS, &[0.1], Some(asked)), "a right command");
    let torque = |gateway: &mut Gateway, now_ns| {
        gateway.actuate(now_ns).engine.map(|engine| engine.engine_torque_nm)
    };
    // 5000 N m/s over periods of 100 ms, from what the engine gave.
    assert_eq!(torque(&mut gateway, 0), Some(1000.0));
    assert_eq!(torque(&mut gateway, 1), Some(1500.0));
    let all = [2, 3, 4].map(|now_ns| torque(&mut gateway, now_ns));
    assert_eq!(all, [Some(2000.0), Some(2200.0), Some(2200.0)]);
    assert_eq!(torque(&mut gateway, STEP_NS), None, "the rest of the plan is acceleration");
    let bad = Demand { engine_torque_nm: f64::NAN, ..asked };
    let accepted = gateway.accept(STEP_NS, STEP_NS, STEP_NS, &[0.1], Some(bad));
    assert!(!accepted);
}

#[test]
fn a_single_request_is_held_for_one_step_and_then_only_if_it_brakes() {
    for (request, later) in [(1.5, 0.0), (-1.5, -1.5)] {
        let mut gateway = gateway();
        assert!(gateway.accept(0, 0, STEP_NS, &[request], None), "it is valid");
        assert_eq!(at(&mut gateway, STEP_NS), (request, Source::Plan));
        assert_eq!(at(&mut gateway, 2 * STEP_NS), (later, Source::Plan));
    }
}

#[test]
fn a_plant_that_never_receives_a_command_stops() {
    let mut gateway = gateway();
    assert_eq!(at(&mut gateway, 1_000_000_000).1, Source::None);
    assert_eq!(at(&mut gateway, 1_010_000_000), (-2.5, Source::StopInLane));
}

#[test]
fn unusable_commands_are_refused_and_change_nothing() {
    let mut gateway = gateway();
    assert!(gateway.accept(0, STEP_NS / 2, STEP_NS, &[1.0], None), "it is valid");
    for (start, step, plan, why) in [
        (STEP_NS, STEP_NS, &[][..], "empty"),
        (STEP_NS, 0, &[0.0], "empty"),
        (STEP_NS, STEP_NS, &[0.0, f64::NAN], "not finite"),
        (STEP_NS, STEP_NS, &[f64::NEG_INFINITY], "not finite"),
        (STEP_NS / 2, STEP_NS, &[0.0], "not newer"),
        (0, STEP_NS, &[0.0], "not newer"),
        (STEP_NS + 1, STEP_NS, &[0.0], "from the future"),
        (u64::MAX, u64::MAX - 1, &[0.0], "from the future"),
    ] {
        assert!(!gateway.accept(0, start, step, plan, None), "{why}");
    }
    assert_eq!(at(&mut gateway, STEP_NS), (1.0, Source::Command));
}

#[test]
fn a_plan_longer_than_the_store_is_cut() {
    let mut gateway = gateway();
    assert!(gateway.accept(0, 0, PERIOD_NS / 10, &[-0.5; 1000], None), "it is valid");
    assert_eq!(at(&mut gateway, 2 * STEP_NS), (-0.5, Source::Plan));
}

#[test]
fn range_and_rate_are_bounded_and_reported() {
    let mut plant = Plant::default();
    plant.gateway.max_rise_mps3 = JerkMagnitude::of(10.0);
    plant.gateway.max_fall_mps3 = JerkMagnitude::of(50.0);
    let mut gateway = Gateway::new(&plant);
    assert!(gateway.accept(0, 0, STEP_NS, &[100.0, -100.0], None), "it is valid");
    let first = gateway.actuate(0);
    assert!(first.limited && (first.request_mps2 - 0.1).abs() < 1e-12);
    let second = gateway.actuate(STEP_NS);
    assert!(second.limited && (second.request_mps2 + 0.4).abs() < 1e-12);
    let mut free = self::gateway();
    assert!(free.accept(0, 0, STEP_NS, &[100.0, -100.0], None), "it is valid");
    assert_eq!(free.actuate(0).request_mps2, 5.0);
    assert_eq!(free.actuate(STEP_NS).request_mps2, -8.0);
}

#[test]
fn the_stop_is_as_hard_as_the_plan_was_at_its_worst() {
    let lost_ns = 2_000_000_000;
    for (plan, expected) in [
        (&[1.0, 0.5][..], -2.5),
        (&[-1.0, -2.0], -2.5),
        (&[-4.0], -4.0),
        (&[-1.0, -4.0, 0.0], -4.0),
        (&[-6.0, -3.0], -6.0),
        (&[-20.0], -8.0),
    ] {
        let mut gateway = gateway();
        assert!(gateway.accept(0, 0, STEP_NS, plan, None), "it is valid");
        assert_eq!(at(&mut gateway, lost_ns), (expected, Source::StopInLane), "{plan:?}");
        // The launcher's order stops as hard, at once and whatever comes.
        let mut gateway = self::gateway();
        assert!(gateway.accept(0, 0, STEP_NS, plan, None), "it is valid");
        gateway.stop();
        assert_eq!(at(&mut gateway, 0), (expected, Source::StopInLane), "{plan:?}");
    }
    let mut gateway = gateway();
    gateway.stop();
    assert!(gateway.accept(0, 0, STEP_NS, &[1.0], None), "it is valid");
    assert_eq!(at(&mut gateway, 0), (-2.5, Source::StopInLane), "an order to stop stays");
}

#[test]
fn a_command_is_overdue_after_its_step_and_the_margin() {
    let mut gateway = gateway();
    assert!(gateway.is_commanded(1_000_000_000), "the first one has a second");
    assert!(!gateway.is_commanded(1_000_000_001));
    assert!(gateway.accept(STEP_NS, STEP_NS, STEP_NS, &[0.5], None), "it is valid");
    // Due at 0.2 s, with a margin of 0.1 s.
    assert!(gateway.is_commanded(3 * STEP_NS - 1));
    assert!(!gateway.is_commanded(3 * STEP_NS));
}

#[test]
fn a_restarted_gateway_goes_on_from_its_last_request_and_keeps_an_order_to_stop() {
    let mut plant = Plant::default();
    plant.gateway.max_rise_mps3 = JerkMagnitude::of(10.0);
    let mut gateway = Gateway::new(&plant);
    assert!(gateway.accept(0, 0, STEP_NS, &[-0.4], None), "it is valid");
    assert_eq!(gateway.actuate(0).request_mps2, -0.4);
    let mut next = Gateway::new(&plant);
    next.kept = gateway.kept;
    assert!(next.accept(0, 0, STEP_NS, &[1.0], None), "it is valid");
    let request = next.actuate(0).request_mps2;
    assert!((request + 0.3).abs() < 1e-12, "0.1 m/s² above the last one: {request}");
    next.stop();
    let mut last = Gateway::new(&plant);
    last.kept = next.kept;
    assert_eq!(last.actuate(0).source, Source::StopInLane);
}

#[test]
fn a_torque_that_goes_up_or_down_is_reported_as_limited_and_a_brake_never_pushes() {
    let mut gateway = gateway();
    for (torque_nm, service_brake_n, given, limited) in [
        (400.0, 0.0, (400.0, 0.0), false),
        (-300.0, 50.0, (-100.0, 50.0), true),
        (-9e3, 50.0, (-600.0, 50.0), true),
        (-9e3, 50.0, (-1100.0, 50.0), true),
        (-9e3, 50.0, (-1500.0, 50.0), true),
        (-1500.0, -50.0, (-1500.0, 0.0), true),
    ] {
        let start_ns = gateway.plan.as_ref().map_or(0, |plan| plan.start_ns + STEP_NS);
        let asked = Demand { engine_torque_nm: torque_nm, service_brake_n, gear: Some(3) };
        let taken = gateway.accept(start_ns, start_ns, STEP_NS, &[0.0], Some(asked));
        assert!(taken);
        let found = gateway.actuate(start_ns);
        let engine = found.engine.expect("a torque was asked for");
        assert_eq!((engine.engine_torque_nm, engine.service_brake_n), given);
        assert_eq!((engine.gear, found.limited), (Some(3), limited));
        // The engine's own torque counts only while none is asked for.
        gateway.engine_gives(1e9);
    }
    for bad in [
        Demand { engine_torque_nm: f64::NAN, service_brake_n: 0.0, gear: None },
        Demand { engine_torque_nm: 0.0, service_brake_n: f64::INFINITY, gear: None },
    ] {
        let accepted = gateway.accept(10 * STEP_NS, 10 * STEP_NS, STEP_NS, &[0.0], Some(bad));
        assert!(!accepted);
    }
}

/// The ladder as the module's table has it, written down once more by time alone.
fn expected(plan: &[f64], lost_for_ns: u64) -> (f64, Source) {
    const FOLLOW_NS: u64 = 1_000_000_000;
    let (last, step) = (*plan.last().expect("it has a request"), lost_for_ns / STEP_NS);
    if lost_for_ns < STEP_NS {
        (plan[0], Source::Command)
    } else if lost_for_ns <= STEP_NS + FOLLOW_NS {
        let held = if step == plan.len() as u64 { last } else { last.min(0.0) };
        (plan.get(step as usize).copied().unwrap_or(held), Source::Plan)
    } else {
        let worst = plan.iter().copied().fold(-2.5, f64::min);
        (worst, Source::StopInLane)
    }
}

proptest! {
    #[test]
    fn whatever_comes_the_request_is_finite_and_in_range(
        commands in prop::collection::vec(
            (0u64..40, prop::collection::vec(prop::num::f64::ANY, 0..4)), 0..60),
    ) {
        let mut plant = Plant::default();
        plant.gateway.max_rise_mps3 = JerkMagnitude::of(20.0);
        let mut gateway = Gateway::new(&plant);
        let (mut now, mut last) = (0, 0.0);
        for (wait, plan) in commands {
            let _ = gateway.accept(now, now, STEP_NS, &plan, None);
            for _ in 0..wait {
                let request = gateway.actuate(now).request_mps2;
                prop_assert!((-8.0..=5.0).contains(&request));
                prop_assert!(request <= last + 0.2 + 1e-12);
                last = request;
                now += PERIOD_NS;
            }
        }
    }

    #[test]
    fn without_commands_the_ladder_is_gone_down_as_the_table_says(
        plan in prop::collection::vec(-7.0..4.0f64, 1..20), start in 0u64..5,
        waits in prop::collection::vec(1u64..20, 1..30),
    ) {
        let mut gateway = gateway();
        let start_ns = start * PERIOD_NS;
        assert!(gateway.accept(start_ns, start_ns, STEP_NS, &plan, None), "it is valid");
        let mut now_ns = start_ns;
        for wait in waits {
            now_ns += wait * PERIOD_NS;
            prop_assert_eq!(at(&mut gateway, now_ns), expected(&plan, now_ns - start_ns));
        }
    }
}
