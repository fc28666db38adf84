//! Points and outlines, with the numbers that follow by hand.

use bytemuck::Zeroable;

use super::tests::point;
use super::*;
use crate::radar::detections::DetectionRadar;
use crate::radar::receiver::Accuracy;

/// A receiver whose range has a deviation of 0.1 m, its range rate 0.2 m/s and its azimuth 0.01 rad.
fn receiver() -> Receiver {
    let text = "schema_version = 1\nname = \"by-hand\"\nduration_s = 10\n";
    let scenario = scenario::Scenario::parse("by-hand", text).expect("a scenario");
    let exactly = |floor: f64| Accuracy { resolution: 0.0, floor };
    Receiver {
        range: exactly(0.1),
        range_rate: exactly(0.2),
        azimuth: exactly(0.01),
        ..*DetectionRadar::new(&scenario).receiver()
    }
}

/// A detection at a place of the body's axes, as the point that it is on a course.
fn seen_at(x_m: f64, y_m: f64, range_rate_mps: f64, slip_rad: f64, course: &Course) -> Point {
    let detection = Detection {
        range_m: libm::hypot(x_m, y_m),
        range_rate_mps,
        azimuth_rad: libm::atan2(y_m, x_m),
        snr_db: 20.0,
        ..Detection::zeroed()
    };
    let motion = Motion { speed_mps: 20.0, yaw_rate_radps: None, slip_rad };
    Point::new(7, &detection, 20.0, &receiver()).on(course, &detection, &motion)
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
}

#[test]
fn a_point_on_a_straight_road_is_where_it_was_seen() {
    let point = seen_at(40.0, 30.0, -12.0, 0.01, &Course::STRAIGHT);
    assert_near(point.x_m, 40.0);
    assert_near(point.y_m, 30.0);
    assert_near(point.aspect_m, 30.0);
    assert_near(point.direction.0, 0.8);
    assert_near(point.direction.1, 0.6);
    // The ego drives with 16 m/s along the line of sight.
    assert_near(point.ground_speed_mps, 4.0);
    assert_eq!((point.range_rate_mps, point.detection, point.owner), (-12.0, 7, None));
    assert_near(point.range_variance, 0.01);
    assert_near(point.range_rate_variance, 0.04);
    // 0.01 rad at 50 m, seen at an angle: 0.5 m / 0.8.
    assert_near(point.lateral_variance, 0.625 * 0.625);
}

#[test]
fn a_point_on_a_curve_moves_as_it_would_on_the_straight_road() {
    // A left curve of 100 m; the point is 40 m along it and 2 m inside.
    let course = Course::bent(0.0, |_| 0.01);
    let (sine, cosine) = libm::sincos(0.4);
    let (x_m, y_m) = (98.0 * sine, 100.0 - 98.0 * cosine);
    let point = seen_at(x_m, y_m, -3.0, 0.01, &course);
    assert_near(point.x_m, 40.0);
    assert_near(point.y_m, 2.0);
    let azimuth = libm::atan2(y_m, x_m);
    let from_course = azimuth - 0.4;
    assert_near(point.direction.0, libm::cos(from_course));
    assert_near(point.direction.1, libm::sin(from_course));
    assert_near(point.aspect_m, libm::hypot(x_m, y_m) * libm::sin(from_course));
    // The bumper drives with 20 m/s, 0.01 rad to the left.
    let ground_mps = -3.0 + 20.0 * (libm::cos(azimuth) + 0.01 * libm::sin(azimuth));
    assert_near(point.ground_speed_mps, ground_mps);
    // Two metres inside a curve of 100 m, 0.98 m make a metre along the course.
    assert_near(point.range_rate_mps, ground_mps / 0.98 - 20.0 * libm::cos(from_course));
}

#[test]
fn points_farther_apart_than_a_vehicle_is_wide_are_parted() {
    let owners = |apart_m: f64, expected_m: f64| {
        let mut points = [point(40.0, 1.0, 0.0), point(40.0, 1.0 + apart_m, 0.0)];
        points.iter_mut().for_each(|point| point.owner = Some(3));
        part(&mut points, 3, expected_m, &Numbers::DEFAULT);
        points.map(|point| point.owner.is_some())
    };
    // 2.6 m and three deviations of the difference of two that have 0.2 m each.
    let limit_m = 2.6 + 3.0 * f64::sqrt(0.08);
    assert_eq!(owners(limit_m - 0.01, 1.0), [true, true]);
    let middle_m = 1.0 + 0.5 * (limit_m + 0.01);
    assert_eq!(owners(limit_m + 0.01, middle_m - 0.01), [true, false]);
    assert_eq!(owners(limit_m + 0.01, middle_m + 0.01), [false, true]);
    // Points of another track stay with it.
    let mut other = [point(40.0, -9.0, 0.0), point(40.0, 9.0, 0.0)];
    other.iter_mut().for_each(|point| point.owner = Some(4));
    part(&mut other, 3, 0.0, &Numbers::DEFAULT);
    assert_eq!(other.map(|point| point.owner), [Some(4); 2]);
}
