//! Tests of the figures across the road.

use scenario::Scenario;

use super::*;

const PERIOD_NS: u64 = 10_000_000;

fn referee() -> Referee {
    let text = "schema_version = 1\nname = \"x\"\n[road.plan]\npieces = [{ line_m = 900 }]\n";
    Referee::new(&Scenario::parse("x", text).expect("it is right"), &Numbers::DEFAULT)
}

fn sample(lateral_m: f64, lateral_acceleration_mps2: f64) -> InPlane {
    InPlane { lateral_m, lateral_acceleration_mps2, closing_at_contact_mps: None }
}

const EGO: State = State { position_m: 0.0, speed_mps: 20.0, acceleration_mps2: 0.0 };

#[test]
fn the_lateral_jerk_is_a_mean_of_half_a_second() {
    let mut referee = referee();
    for step in 0..400_u64 {
        let time_s = 0.01 * step as f64;
        // 2 m/s³ from 1 s to 2 s, and a spike of one sample that a mean hides.
        let spike = if step == 300 { 1.0 } else { 0.0 };
        let acceleration = (2.0 * (time_s - 1.0)).clamp(0.0, 2.0) + spike;
        let shown = sample(0.0, acceleration);
        referee.observe(step * PERIOD_NS, &EGO, None, [], Some(&shown));
    }
    let figures = referee.figures();
    let jerk = figures.max_abs_lateral_jerk_mps3.expect("it has a plan");
    assert!((jerk - 2.0).abs() < 0.05, "{jerk}");
    assert_eq!(figures.max_abs_lateral_accel_mps2, Some(3.0));
    assert_eq!(figures.outside_lane_s, Some(0.0));
}

#[test]
fn the_bumper_is_outside_a_lane_of_three_and_a_half_metres_beyond_0_85_m() {
    let mut referee = referee();
    for step in 0..300_u64 {
        let shown = sample(if (100..200).contains(&step) { -0.86 } else { 0.84 }, 0.0);
        referee.observe(step * PERIOD_NS, &EGO, None, [], Some(&shown));
    }
    let outside_s = referee.figures().outside_lane_s.expect("it has a plan");
    assert!((outside_s - 1.0).abs() < 1e-9, "{outside_s}");
}

#[test]
fn contact_is_that_of_the_bodies_and_not_of_the_gap() {
    let mut referee = referee();
    let ahead = Ahead { gap_m: -0.5, speed_mps: 15.0, acceleration_mps2: 0.0 };
    let beside = sample(0.0, 0.0);
    let found = referee.observe(0, &EGO, Some(&ahead), [], Some(&beside));
    assert_eq!(found, None, "a gap on the axis is used up, and the bodies are apart");
    let touches = InPlane { closing_at_contact_mps: Some(4.0), ..beside };
    let found = referee.observe(PERIOD_NS, &EGO, Some(&ahead), [], Some(&touches));
    assert_eq!(found, Some(Violation::Collision { time_s: 0.01, closing_mps: 4.0 }));
}

#[test]
fn without_a_plan_the_figures_have_no_value() {
    let text = "schema_version = 1\nname = \"x\"\n";
    let mut referee =
        Referee::new(&Scenario::parse("x", text).expect("it is right"), &Numbers::DEFAULT);
    referee.observe(0, &EGO, None, [], None);
    let figures = referee.figures();
    assert_eq!((figures.max_abs_lateral_accel_mps2, figures.outside_lane_s), (None, None));
}
