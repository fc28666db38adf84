//! A detection's place, speed and accuracy, computed by hand.

use super::*;

fn detection(range_m: f64, azimuth_rad: f64, range_rate_mps: f64, snr_db: f64) -> Detection {
    Detection { range_m, azimuth_rad, range_rate_mps, snr_db, ..bytemuck::Zeroable::zeroed() }
}

/// The point of a detection of an ego with 20 m/s on a straight road.
fn point_of(detection: &Detection) -> Option<Point> {
    Point::of(detection, 20.0, &Corridor::default())
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
        "{found}, expected {expected}"
    );
}

#[test]
fn a_point_on_a_straight_has_the_accuracy_of_its_echo() {
    for (azimuth_rad, snr_db) in [(0.3, 20.0), (-0.3, 20.0), (0.5, 40.0), (0.1, -5.0), (0.1, 80.0)]
    {
        let point = point_of(&detection(50.0, azimuth_rad, -5.0, snr_db)).expect("ahead");
        let (sine, cosine) = (libm::sin(azimuth_rad), libm::cos(azimuth_rad));
        assert_near(point.x_m, 50.0 * cosine);
        assert_near(point.y_m, 50.0 * sine);
        assert_near(point.speed_mps, 20.0 - 5.0 / cosine);
        assert_near(point.tangent, libm::tan(azimuth_rad));
        // An echo as strong as the noise has the whole weak deviation, one of 20 dB a tenth of it.
        let weak = libm::pow(10.0, -f64::clamp(snr_db, 0.0, 60.0) / 20.0);
        let azimuth2 = 0.0018_f64.powi(2) + (0.0205 * weak).powi(2);
        // Across the road: the range's 0.1 m by the sine, the azimuth by x / cos².
        let across_m2 = (0.1 * sine).powi(2) + (50.0 / cosine).powi(2) * azimuth2;
        assert_near(point.variance_m2, across_m2 + 0.03_f64.powi(2));
        assert_near(point.speed_variance, (0.04 / cosine).powi(2));
    }
}

#[test]
fn along_a_circle_a_place_and_its_speed_count_by_the_road_there() {
    let way = Corridor::circle(1.0 / 250.0, 0.01, 0.0);
    for (along_m, off_m) in [(40.0, 0.0), (60.0, 3.0), (60.0, -3.0)] {
        let (x_m, y_m) = way.to_body(along_m, off_m);
        let (range_m, azimuth_rad) = (libm::hypot(x_m, y_m), libm::atan2(y_m, x_m));
        // It drives along the road with 12 m/s, the ego with 20 along its way.
        let road_rad = way.heading_rad(along_m);
        let rate_mps =
            12.0 * libm::cos(azimuth_rad - road_rad) - 20.0 * libm::cos(azimuth_rad - 0.01);
        let echo = detection(range_m, azimuth_rad, rate_mps, 25.0);
        let point = Point::of(&echo, 20.0, &way).expect("it drives");
        let (along_off_m, beside_off_m) = (point.x_m - along_m, point.y_m - off_m);
        assert!(along_off_m.abs() < 1e-9 && beside_off_m.abs() < 1e-9, "{point:?}");
        assert!((point.speed_mps - 12.0).abs() < 1e-9, "{point:?}");
        assert!((point.tangent - libm::tan(azimuth_rad - road_rad)).abs() < 1e-9, "{point:?}");
    }
}

#[test]
fn objects_beside_the_road_and_across_it_are_left_out() {
    let is_there = |x_m: f64, y_m: f64, speed_mps: f64| {
        let (range_m, azimuth_rad) = (libm::hypot(x_m, y_m), libm::atan2(y_m, x_m));
        let rate_mps = (speed_mps - 20.0) * libm::cos(azimuth_rad);
        point_of(&detection(range_m, azimuth_rad, rate_mps, 20.0)).is_some()
    };
    assert!(is_there(40.0, 4.9, 0.0) && is_there(40.0, -4.9, 0.0));
    assert!(!is_there(40.0, 5.1, 0.0) && !is_there(40.0, -5.1, 0.0));
    // Below 2 m/s it stands, in either direction.
    assert!(!is_there(40.0, 6.0, 1.9) && !is_there(40.0, 6.0, -1.9));
    assert!(is_there(40.0, 6.0, 2.1) && is_there(40.0, 6.0, -2.1));
    // The cosine must be 0.1 at least: 84.3 degrees.
    assert!(is_there(1.0, 9.9, 10.0) && !is_there(1.0, 10.1, 10.0));
    assert!(!is_there(-10.0, 0.5, 10.0), "behind the antenna");
}
