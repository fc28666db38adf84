//! One test per trap: what the literal law does there, and that the robust law does not.
//!
//! Trap 8, noise, is in `published.rs`: it needs the published run.

use super::plant::{Actor, DT, advance_ego, ask, input};
use law::{Ego, Input, Output, Target};
use laws::six_mode::deceleration::border_m;
use laws::six_mode::{Boundaries, Mode, Parameters, Parts, SIX_MODE, SixMode, Spacing};

const PERIOD: f64 = 0.1;

fn literal() -> SixMode {
    SixMode::new(Parameters::literal()).expect("the built-in set is valid")
}

/// The cures on the paper's own boundaries.
fn cured() -> Parameters {
    let acceleration_mps2 = 1.0;
    let deceleration_parts = Parts::EqualSlices;
    let spacing = Spacing::Paper;
    Parameters {
        spacing,
        deceleration_parts,
        acceleration_mps2,
        dwell_s: 0.5,
        ..Parameters::default()
    }
}

fn robust() -> SixMode {
    SixMode::new(cured()).expect("the built-in set is valid")
}

/// A single release; set speed 40 m/s unless a test is about it.
fn seen(speed: f64, gap: f64, relative: f64) -> Input {
    let ego = Ego { speed_mps: speed, ..Ego::default() };
    let target =
        Target { track_id: 1, gap_m: gap, relative_speed_mps: relative, ..Target::default() };
    input(0.0, PERIOD, 40.0, ego, Some(target))
}

/// Feeds one input after the other; returns all outputs.
fn feed(law: &mut SixMode, inputs: impl IntoIterator<Item = Input>) -> Vec<Output> {
    inputs.into_iter().map(|i| ask(law, &i)).collect()
}

fn changes(outputs: &[Output]) -> usize {
    outputs.windows(2).filter(|w| w[0].mode != w[1].mode).count()
}

/// Closed loop behind a target of constant speed; returns (mode, request, ego speed) per release.
fn follow(
    law: &mut SixMode,
    (speed, gap, lead_speed): (f64, f64, f64),
    set_speed: f64,
    duration: f64,
) -> Vec<(Mode, f64, f64)> {
    let mut ego = Ego { speed_mps: speed, ..Ego::default() };
    let mut lead = Actor { id: 1, position: gap, speed: lead_speed };
    let mut rows = Vec::new();
    let mut request = 0.0;
    for step in 0..(duration / DT) as u32 {
        if step % 10 == 0 {
            let time = f64::from(step) * DT;
            let target = Some(lead.seen_from(&ego));
            request = ask(law, &input(time, PERIOD, set_speed, ego, target)).request_mps2();
            rows.push((law.mode.unwrap_or(Mode::Cruise), request, ego.speed_mps));
        }
        advance_ego(&mut ego, request, 0.2);
        lead.advance(0.0);
    }
    rows
}

#[test]
fn trap_1_full_brake_blips_at_walking_pace() {
    let blips = |law: &mut SixMode| {
        follow(law, (1.0, 12.0, 0.0), 20.0, 30.0)
            .iter()
            .filter(|(mode, request, _)| *mode == Mode::Avoid || *request < -3.75)
            .count()
    };
    assert!(blips(&mut literal()) > 0);
    assert_eq!(blips(&mut robust()), 0);
    let p = Parameters::default();
    for v_h in [0.0, 0.4, 0.8, 1.1] {
        let b = Boundaries::literal(&p, v_h, -0.01);
        assert!(b.warning_m < b.braking_m, "the trap is there at {v_h} m/s");
    }
}

#[test]
fn trap_2_no_braking_distance_behind_a_faster_car() {
    // A car at 20 m/s, one metre ahead of an ego at 4 m/s.
    let one = seen(4.0, 1.0, 16.0);
    let out = ask(&mut literal(), &one);
    assert!(out.figures[1] < 0.0, "R_b = {}", out.figures[1]);
    assert_ne!(out.mode, Mode::Avoid as u32);
    let out = ask(&mut robust(), &one);
    assert_eq!(out.figures[1], 4.0);
    assert_eq!(out.mode, Mode::Avoid as u32);
}

#[test]
fn trap_3_approach_without_bound_before_the_gentlest_level() {
    let p = cured();
    let edge = Boundaries::robust(&p, 25.0, -8.0).warning_m;
    let demand = |law: &mut SixMode, gap: f64| ask(law, &seen(25.0, gap, -8.0)).figures[6];
    // Just above R_w the literal law brakes fully, just below it with the gentlest level of region 2.
    assert_eq!(demand(&mut literal(), edge + 0.05), -p.braking_mps2);
    assert_eq!(demand(&mut literal(), edge - 0.05), -1.25);
    assert_eq!(demand(&mut robust(), edge + 0.05), -1.0);
    assert_eq!(demand(&mut robust(), edge - 0.05), -0.5);
}

#[test]
fn trap_4_following_distance_with_a_pole_and_a_cliff() {
    let p = Parameters::default();
    assert!(Boundaries::literal(&p, 20.0, -2.0).following_m.is_infinite());
    assert!(Boundaries::robust(&p, 20.0, -2.0).following_m < 200.0);
    // At half a metre per second the boundary moves 20 m for each m/s. So noise of 0.05 m/s on the relative speed makes
    // the literal law alternate, without any change of gap.
    let edge = Boundaries::literal(&p, 20.0, 0.5).following_m;
    let alternating = || (0..40).map(|k| seen(20.0, edge, if k % 2 == 0 { 0.45 } else { 0.55 }));
    assert_eq!(changes(&feed(&mut literal(), alternating())), 39);
    assert!(changes(&feed(&mut robust(), alternating())) <= 1);
}

#[test]
fn trap_5_no_row_for_equal_speeds() {
    // Five metres behind a car of the same speed, 20 m/s: the paper's table is silent.
    let mut law = literal();
    let out = ask(&mut law, &seen(20.0, 5.0, 0.0));
    assert_eq!((law.mode, out.request_mps2()), (None, 0.0));
    let mut law = robust();
    let out = ask(&mut law, &seen(20.0, 5.0, 0.0));
    assert_eq!(law.mode, Some(Mode::Avoid));
    assert!(out.request_mps2() < 0.0);
    // A relative speed that trembles around zero beyond R_j.
    let trembling = || (0..40).map(|k| seen(20.0, 179.0, if k % 2 == 0 { 0.02 } else { -0.02 }));
    assert_eq!(changes(&feed(&mut literal(), trembling())), 39);
    assert_eq!(changes(&feed(&mut robust(), trembling())), 0);
}

#[test]
fn trap_6_a_faster_lead_pulls_the_ego_over_its_set_speed() {
    let fastest = |law: &mut SixMode| {
        follow(law, (20.0, 100.0, 24.0), 20.0, 20.0).iter().fold(0.0, |m: f64, r| m.max(r.2))
    };
    assert!(fastest(&mut literal()) > 22.0);
    assert!(fastest(&mut robust()) < 20.1);
}

#[test]
fn trap_6_steady_and_decelerate_take_turns_behind_a_slightly_faster_lead() {
    let turns = |law: &mut SixMode| {
        follow(law, (20.7, 96.0, 23.5), 30.0, 40.0).windows(2).filter(|w| w[0].0 != w[1].0).count()
    };
    assert!(turns(&mut literal()) >= 10);
    assert!(turns(&mut robust()) <= 2);
}

#[test]
fn trap_7_avoid_ends_and_begins_again() {
    let p = cured();
    let edge = Boundaries::robust(&p, 20.0, -3.0).braking_m;
    let trembling =
        || (0..40).map(|k| seen(20.0, edge + if k % 2 == 0 { -0.3 } else { 0.3 }, -3.0));
    assert_eq!(changes(&feed(&mut literal(), trembling())), 39);
    assert_eq!(changes(&feed(&mut robust(), trembling())), 0);
}

#[test]
fn trap_9_the_edge_of_the_range() {
    let trembling = || (0..40).map(|k| seen(20.0, if k % 2 == 0 { 180.3 } else { 179.7 }, -2.0));
    assert_eq!(changes(&feed(&mut literal(), trembling())), 39);
    assert_eq!(changes(&feed(&mut robust(), trembling())), 0);
}

#[test]
fn trap_9_steps_of_the_request() {
    let p = Parameters::default();
    let worst = |law: &mut SixMode| {
        follow(law, (25.0, 170.0, 10.0), 30.0, 30.0)
            .windows(2)
            .filter(|w| w[1].0 != Mode::Avoid)
            .fold(0.0, |m: f64, w| m.max((w[1].1 - w[0].1).abs() / PERIOD))
    };
    assert!(worst(&mut literal()) > 2.0 * p.jerk_limit_mps3);
    assert!(worst(&mut robust()) <= p.jerk_limit_mps3 * (1.0 + 1e-9));
}

#[test]
fn trap_9_a_new_target_is_not_mixed_with_the_old_one() {
    // From a car 100 m ahead to one that cuts in at 12 m: avoided in the same release.
    let mut law = robust();
    let _ = feed(&mut law, (0..20).map(|_| seen(20.0, 100.0, -1.0)));
    let mut cut_in = seen(20.0, 12.0, -1.0);
    cut_in.target.as_mut().expect("it has one").track_id = 2;
    assert_eq!(ask(&mut law, &cut_in).mode, Mode::Avoid as u32);
    // Under the old track's name the filter would have accepted it later.
    let mut law = robust();
    let _ = feed(&mut law, (0..20).map(|_| seen(20.0, 100.0, -1.0)));
    assert_ne!(ask(&mut law, &seen(20.0, 12.0, -1.0)).mode, Mode::Avoid as u32);
}

#[test]
fn the_output_names_mode_reason_and_boundaries() {
    let mut law = robust();
    let formulation = SIX_MODE.formulations[0];
    let out = ask(&mut law, &seen(20.0, 12.0, -1.0));
    assert_eq!(formulation.modes[out.mode as usize], "avoid");
    assert_eq!(formulation.reasons[out.mode_reason as usize], "gap below R_b");
    let b = Boundaries::robust(&law.parameters, 20.0, -1.0);
    assert_eq!(out.figures[..4], [b.warning_m, b.braking_m, b.following_m, b.desired_m]);
    assert_eq!(formulation.figure_names()[..4], ["r_w_m", "r_b_m", "r_j_m", "r_x_m"]);
}

/// The decelerate mode's output is the mean of the last four demands.
#[test]
fn decelerate_averages_four_samples() {
    let p = Parameters::literal();
    let mut law = literal();
    let b = Boundaries::literal(&p, 20.0, -1.0);
    let gap = |part: usize| 0.5 * (border_m(&p, -1.0, &b, part) + border_m(&p, -1.0, &b, part + 1));
    let outputs = feed(&mut law, [2, 4, 6, 7, 7].map(|part| seen(20.0, gap(part), -1.0)));
    let requests: Vec<f64> = outputs.iter().map(Output::request_mps2).collect();
    assert_eq!(requests, [-1.25, -1.75, -6.75 / 3.0, -2.625, -3.25]);
}
