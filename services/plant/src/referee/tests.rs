use proptest::prelude::*;
use scenario::builtin;
use scenario::quantity::{Distance, TimeConstant};
use scenario::v2x::Phase;

use super::*;

const PERIOD_NS: u64 = 10_000_000;

fn scenario(name: &str) -> Scenario {
    let builtin = builtin::find(name).expect("it is built in");
    Scenario::parse(name, builtin.text).expect("it is right")
}

/// The same with a gap to measure against, as the launcher adds it.
fn following() -> Scenario {
    let mut scenario = scenario("following");
    scenario.referee.desired_gap = Some(DesiredGap::Headway {
        time_headway_s: TimeConstant::of(1.5),
        standstill_distance_m: Distance::of(5.0),
    });
    scenario
}

fn state(position_m: f64, speed_mps: f64, acceleration_mps2: f64) -> State {
    State { position_m, speed_mps, acceleration_mps2 }
}

fn signal(id: u32, stop_line_m: f64, phase: Phase, ends_s: f64) -> SignalTruth {
    let next_phase = if phase == Phase::Red { Phase::Green } else { Phase::Red };
    SignalTruth { id, stop_line_m, phase, ends_ns: Some((ends_s * 1e9) as u64), next_phase }
}

/// Drives at constant speed past one signal that is `phase` until `ends_s`.
fn pass(speed: f64, stop_line_m: f64, phase: Phase, ends_s: f64) -> Referee {
    let mut referee = Referee::new(&scenario("cacc-a"), &Numbers::DEFAULT);
    for k in 0..=1000 {
        let t = k as f64 * 0.01;
        let mut truth = signal(1, stop_line_m, phase, ends_s);
        if t >= ends_s {
            truth = SignalTruth { phase: truth.next_phase, ends_ns: None, ..truth };
        }
        referee.observe(k * PERIOD_NS, &state(speed * t, speed, 0.0), None, [truth], None);
    }
    referee
}

#[test]
fn crossing_and_switch_are_interpolated() {
    let referee = pass(15.0, 65.05, Phase::Green, 5.004);
    let figures = referee.figures();
    let close =
        |figure: Option<f64>, value: f64| (figure.expect("it applies") - value).abs() < 1e-9;
    assert!(close(figures.stop_line_crossing_s, 65.05 / 15.0));
    assert!(close(figures.past_stop_line_at_switch_m, 15.0 * 5.004 - 65.05));
    assert_eq!(referee.stop_lines.red_lights, 0);
}

#[test]
fn a_red_light_is_judged_at_the_instant_of_crossing() {
    // The line is crossed at 5.0033 s, between the samples at 5.00 s and 5.01 s.
    let line = 15.0 * 5.0 + 0.05;
    assert_eq!(pass(15.0, line, Phase::Green, 5.004).violation, None);
    let violation = pass(15.0, line, Phase::Green, 5.003).violation;
    assert!(matches!(violation, Some(Violation::RedLight { time_s, id: 1 })
            if (time_s - line / 15.0).abs() < 1e-9));
    assert_eq!(pass(15.0, line, Phase::Red, 5.003).violation, None);
    assert!(pass(15.0, line, Phase::Red, 5.004).violation.is_some());
    assert_eq!(pass(15.0, line, Phase::Yellow, 6.0).violation, None);
}

#[test]
fn a_signal_that_is_no_longer_announced_still_counts() {
    let mut referee = Referee::new(&scenario("cacc-a"), &Numbers::DEFAULT);
    let red = SignalTruth { ends_ns: None, ..signal(1, 5.0, Phase::Red, 0.0) };
    assert_eq!(referee.observe(0, &state(4.9, 15.0, 0.0), None, [red], None), None);
    let violation = referee.observe(PERIOD_NS, &state(5.05, 15.0, 0.0), None, [], None);
    assert!(matches!(violation, Some(Violation::RedLight { id: 1, .. })));
}

#[test]
fn the_reference_run_of_scenario_a_gives_the_reference_figures() {
    let csv =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/cacc-a-cacc.csv"));
    let mut referee = Referee::new(&scenario("cacc-a"), &Numbers::DEFAULT);
    for (k, line) in csv.lines().skip(1).enumerate() {
        let row: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
        let truth = signal(1, 80.0, Phase::Green, 5.0);
        let truth = match k < 50 {
            true => truth,
            false => SignalTruth { phase: Phase::Red, ends_ns: None, ..truth },
        };
        let ahead = Ahead { gap_m: row[7], speed_mps: row[8], acceleration_mps2: 0.0 };
        let now_ns = k as u64 * 100_000_000;
        let violation =
            referee.observe(now_ns, &state(row[1], row[2], row[3]), Some(&ahead), [truth], None);
        assert_eq!(violation, None);
    }
    let figures = referee.figures();
    // 3.91 s and 20.2 m in the table of the reconstruction.
    assert!((figures.stop_line_crossing_s.expect("it crosses") - 3.91).abs() < 0.005);
    assert!((figures.past_stop_line_at_switch_m.expect("it switches") - 20.2).abs() < 0.05);
    assert!((figures.min_gap_m.expect("there is a lead") - 24.158_18).abs() < 1e-5);
}

#[test]
fn a_collision_is_reported_once() {
    let mut referee = Referee::new(&scenario("following"), &Numbers::DEFAULT);
    let ahead = |gap_m| Ahead { gap_m, speed_mps: 10.0, acceleration_mps2: 0.0 };
    let ego = state(0.0, 15.0, 0.0);
    assert_eq!(referee.observe(0, &ego, Some(&ahead(0.01)), [], None), None);
    assert_eq!(
        referee.observe(PERIOD_NS, &ego, Some(&ahead(-0.04)), [], None),
        Some(Violation::Collision { time_s: 0.01, closing_mps: 5.0 })
    );
    assert_eq!(referee.observe(2 * PERIOD_NS, &ego, Some(&ahead(-0.09)), [], None), None);
    assert!(matches!(referee.violation, Some(Violation::Collision { .. })));
    assert_eq!(referee.figures().min_ttc_s, Some(0.0));
    assert_eq!(referee.figures().impact_speed_mps, Some(5.0));
}

#[test]
fn figures_that_do_not_apply_are_absent() {
    let mut referee = Referee::new(&following(), &Numbers::DEFAULT);
    assert_eq!(*referee.figures(), ControlFigures::default());
    referee.observe(0, &state(0.0, 25.0, 0.5), None, [], None);
    let figures = referee.figures();
    assert_eq!(figures.min_gap_m, None);
    assert_eq!(figures.min_ttc_s, None);
    assert_eq!(figures.final_gap_error_m, None);
    assert_eq!(figures.final_speed_error_mps, Some(-5.0));
    assert_eq!(figures.max_abs_jerk_mps3, None);
    assert_eq!(figures.min_accel_mps2, Some(0.5));
    // An opening gap has no time to collision.
    let ahead = Ahead { gap_m: 30.0, speed_mps: 26.0, acceleration_mps2: 0.0 };
    referee.observe(PERIOD_NS, &state(0.25, 25.0, 0.4), Some(&ahead), [], None);
    let figures = referee.figures();
    assert_eq!(figures.min_ttc_s, None);
    assert_eq!(figures.final_gap_error_m, Some(30.0 - (1.5 * 25.0 + 5.0)));
    assert!((figures.max_abs_jerk_mps3.expect("two samples") - 10.0).abs() < 1e-9);
}

#[test]
fn the_step_of_the_acceleration_at_a_stop_is_no_jerk() {
    // A car's acceleration ends with its last step, a truck's one sample later.
    for last in [0.0, -1.5] {
        let mut referee = Referee::new(&scenario("following"), &Numbers::DEFAULT);
        let motion = [(0.05, -2.5), (0.025, -2.5), (0.0, last), (0.0, 0.0), (0.001, 0.1)];
        for (index, (speed, acceleration)) in (0..).zip(motion) {
            referee.observe(index * PERIOD_NS, &state(0.0, speed, acceleration), None, [], None);
        }
        let jerk = referee.figures().max_abs_jerk_mps3.expect("five samples");
        assert!(
            (jerk - 10.0).abs() < 1e-9,
            "moving off counts, coming to a stand does not: {jerk}"
        );
    }
}

#[test]
fn a_stop_is_a_stand_after_a_drive() {
    let mut referee = Referee::new(&scenario("following"), &Numbers::DEFAULT);
    for (index, speed) in (0..).zip([0.0, 10.0, 0.0, 0.0, 0.5, 0.0, 0.6, 0.0, 3.0]) {
        referee.observe(index * PERIOD_NS, &state(0.0, speed, 0.0), None, [], None);
    }
    assert_eq!(referee.figures().stops, Some(2), "creeping between two stands makes them one");
}

#[test]
fn mean_squares_weigh_by_time() {
    let mut referee = Referee::new(&following(), &Numbers::DEFAULT);
    // The desired gap at 20 m/s is 1.5 * 20 + 5 = 35 m; the first sample has no length yet.
    for (time_ns, gap_m, acceleration) in
        [(0, 90.0, 0.0), (PERIOD_NS, 38.0, 0.1), (4 * PERIOD_NS, 34.0, 0.1)]
    {
        let ahead = Ahead { gap_m, speed_mps: 20.0, acceleration_mps2: 0.0 };
        referee.observe(time_ns, &state(0.0, 20.0, acceleration), Some(&ahead), [], None);
    }
    let figures = referee.figures();
    let rms = figures.rms_gap_error_m.expect("a lead");
    assert!((rms - ((9.0 + 3.0 * 1.0) / 4.0_f64).sqrt()).abs() < 1e-9, "{rms}");
    let jerk = figures.rms_jerk_mps3.expect("three samples");
    assert!((jerk - (100.0 / 4.0_f64).sqrt()).abs() < 1e-9, "{jerk}");
    assert_eq!(figures.max_abs_gap_error_m, Some(55.0));
}

#[test]
fn a_gap_that_only_the_law_has_has_no_error() {
    let mut referee = Referee::new(&scenario("six-mode"), &Numbers::DEFAULT);
    let ahead = Ahead { gap_m: 30.0, speed_mps: 26.0, acceleration_mps2: 0.0 };
    referee.observe(0, &state(0.0, 25.0, 0.0), Some(&ahead), [], None);
    assert_eq!(referee.figures().final_gap_error_m, None);
    assert_eq!(referee.figures().min_gap_m, Some(30.0));
}

#[test]
fn more_signals_than_slots_drop_the_ones_behind() {
    let mut referee = Referee::new(&scenario("corridor"), &Numbers::DEFAULT);
    for k in 0..100u32 {
        let position = 100.0 * f64::from(k);
        let ahead = signal(k, position + 50.0, Phase::Red, 1e6);
        let now_ns = u64::from(k) * PERIOD_NS;
        let violation = referee.observe(now_ns, &state(position, 10.0, 0.0), None, [ahead], None);
        assert_eq!(violation.is_some(), k == 1);
    }
    assert_eq!(referee.stop_lines.red_lights, 99);
}

proptest! {
    #[test]
    fn no_input_makes_a_figure_that_is_not_a_number(
        samples in prop::collection::vec(
            (prop::num::f64::ANY, prop::num::f64::ANY, prop::num::f64::ANY,
             prop::num::f64::ANY, prop::num::f64::ANY, prop::num::f64::ANY), 1..30),
    ) {
        let mut referee = Referee::new(&scenario("cacc-a"), &Numbers::DEFAULT);
        for (k, (x, v, a, gap_m, speed_mps, line)) in samples.into_iter().enumerate() {
            let ahead = Ahead { gap_m, speed_mps, acceleration_mps2: 0.0 };
            let truth = signal(1, line, Phase::Green, 0.1);
            referee.observe(k as u64 * PERIOD_NS, &state(x, v, a), Some(&ahead), [truth], None);
        }
        let f = referee.figures();
        for figure in [
            f.min_gap_m, f.min_ttc_s, f.final_gap_error_m, f.final_speed_error_mps,
            f.max_abs_jerk_mps3, f.min_accel_mps2, f.max_accel_mps2,
            f.stop_line_crossing_s, f.past_stop_line_at_switch_m, f.rms_gap_error_m,
            f.max_abs_gap_error_m, f.rms_jerk_mps3,
        ].into_iter().flatten() {
            prop_assert!(!figure.is_nan());
        }
    }
}
