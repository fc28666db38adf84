//! The way by the yaw rate, and by a course that the yaw rate checks.

use super::*;
use bytemuck::Zeroable;

const PERIOD_NS: i64 = 50_000_000;
const STALE_NS: i64 = 250_000_000;

fn car() -> Way {
    Way::new(3.6, 0.0055)
}

#[test]
fn a_curvature_comes_with_the_lag_and_stays_when_the_ego_stops() {
    let mut way = car();
    let mut time_ns = 0;
    let mut drive = |way: &mut Way, yaw_rate_radps, speed_mps, cycles| {
        for _ in 0..cycles {
            time_ns += 10_000_000;
            way.take(time_ns, yaw_rate_radps, speed_mps);
        }
    };
    drive(&mut way, 0.0, 20.0, 10);
    drive(&mut way, 0.08, 20.0, 5);
    let risen = way.curvature_perm * 250.0;
    assert!((risen - 0.632).abs() < 1e-3, "a time constant later: {risen}");
    drive(&mut way, 0.08, 20.0, 400);
    assert!((way.curvature_perm - 0.004).abs() < 1e-6);
    drive(&mut way, 0.001, 1.0, 400);
    assert!((way.curvature_perm - 0.004).abs() < 1e-6);
    way.take(time_ns, 9.0, 20.0);
    way.take(time_ns + 10_000_000, f64::NAN, 20.0);
    assert!((way.curvature_perm - 0.004).abs() < 1e-6, "old, and no number");
}

#[test]
fn a_yaw_rate_shows_the_curvature_from_3_mps_on() {
    let curvature_perm = |speed_mps: f64| {
        let mut way = car();
        way.take(0, 0.03, speed_mps);
        assert_eq!(way.yaw_rate_radps, 0.03);
        way.curvature_perm
    };
    assert_eq!((curvature_perm(2.99), curvature_perm(3.0)), (0.0, 0.01));
}

#[test]
fn the_body_points_inwards_when_fast_and_outwards_when_slow() {
    let heading_deg = |radius_m: f64, speed_mps: f64| {
        let mut way = car();
        way.take(0, speed_mps / radius_m, speed_mps);
        way.heading_rad().to_degrees()
    };
    // The design's figures: 0.2° inwards at 500 m and 31.6 m/s, 0.9° outwards at 125 m and 17 m/s.
    assert!((heading_deg(500.0, 31.6) + 0.2).abs() < 0.03, "{}", heading_deg(500.0, 31.6));
    assert!((heading_deg(125.0, 17.0) - 0.9).abs() < 0.05, "{}", heading_deg(125.0, 17.0));
}

/// A course of one curvature that was acquired at a time.
fn course(acquired_ns: i64, curvature_perm: f64) -> Course {
    let mut course = Course::zeroed();
    course.header.acquisition_ns = acquired_ns;
    course.curvatures_perm = [curvature_perm; COURSE_CELLS];
    (course.sigma_50_m, course.sigma_100_m, course.valid_m) = (0.3, 1.2, 150.0);
    course
}

/// Curvature 50 m ahead after scans of an ego that drives a circle of `own_perm` and gets the same course.
fn ahead_perm(own_perm: f64, course: &Course, scans: i64) -> f64 {
    let mut way = Way::new(0.0, 0.0);
    for scan in 0..scans {
        way.take(scan * PERIOD_NS, 20.0 * own_perm, 20.0);
        let mut newest = *course;
        newest.header.acquisition_ns += scan * PERIOD_NS;
        way.look(scan * PERIOD_NS, Some(&newest), STALE_NS);
    }
    let corridor = &way.corridor;
    (corridor.heading_rad(51.0) - corridor.heading_rad(50.0)) / 1.0
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}");
}

#[test]
fn a_young_course_that_agrees_is_the_way_and_else_it_is_the_circle() {
    let mut bend = course(0, 0.0);
    bend.curvatures_perm[3..].fill(0.005);
    assert_near(ahead_perm(0.0, &bend, 40), 0.005);
    assert_near(ahead_perm(0.0, &Course { valid_m: 0.0, ..bend }, 40), 0.0);
    assert_near(ahead_perm(0.0, &Course { sigma_100_m: f64::NAN, ..bend }, 40), 0.0);
    let mut old = bend;
    old.header.acquisition_ns = -STALE_NS - 1;
    assert_near(ahead_perm(0.0, &old, 40), 0.0);
}

#[test]
fn a_course_that_turns_more_than_the_ego_in_the_mean_contradicts() {
    // Three standard deviations of both are 1.15e-3. With a mean over 2 s, 0.005 are more than that after 0.5 s.
    assert_near(ahead_perm(0.0, &course(0, 1.1e-3), 400), 1.1e-3);
    assert_near(ahead_perm(0.0, &course(0, 0.005), 10), 0.005);
    assert_near(ahead_perm(0.0, &course(0, 0.005), 13), 0.0);
    assert_near(ahead_perm(-0.004, &course(0, 0.0), 16), -0.004);
}

#[test]
fn an_older_course_is_moved_on_by_the_way_and_the_turn() {
    let mut way = Way::new(0.0, 0.0);
    way.take(0, 0.1, 20.0);
    let mut bend = course(0, 0.005);
    bend.curvatures_perm[2..].fill(0.0);
    bend.heading_rad = 0.01;
    way.look(200_000_000, Some(&bend), STALE_NS);
    // 4 m of 20 m are driven. Road and body have turned by the same 0.02 rad.
    let corridor = &way.corridor;
    assert_near(corridor.heading_rad(0.0), 0.01);
    assert_near(corridor.heading_rad(40.0), 0.01 + 16.0 * 0.005);
}

#[test]
fn what_stands_is_seen_from_the_place_and_the_heading_after_a_step() {
    let mut way = Way::new(0.0, 0.0);
    way.take(0, 0.16, 20.0);
    // A quarter of a second on a circle of 125 m: 5 m and 0.04 rad.
    let circle = Corridor::circle(1.0 / 125.0, 0.0, 0.0);
    let (x_m, y_m) = way.passed(circle.to_body(40.0, -3.5), 20.0, 0.25);
    let ((along_m, off_m), _) = circle.to_way(x_m, y_m);
    assert!((along_m - 35.0).abs() < 1e-3 && (off_m + 3.5).abs() < 1e-3, "{along_m} {off_m}");
}

#[test]
fn a_straight_road_has_no_course() {
    let mut way = Way::default();
    way.look(0, Some(&course(0, 0.0)), STALE_NS);
    assert_eq!(way.corridor, Corridor::default());
}
