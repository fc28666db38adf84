//! Rows before and behind curves, by places on circles.

use super::*;
use crate::circle::Circle;

/// Places as an ego on a straight sees them whose lane bends with `radius_m` in `begin_m`.
fn before_a_curve(begin_m: f64, radius_m: f64, places: &[Place]) -> Vec<Place> {
    let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
    let seen = places.iter().map(|&(along_m, off_m)| {
        if along_m < begin_m {
            return (along_m, off_m);
        }
        let (x_m, y_m) = curve.to_body(along_m - begin_m, off_m);
        (begin_m + x_m, y_m)
    });
    seen.collect()
}

/// Places as an ego in a curve sees them that ends `end_m` ahead, on the circle that it drives.
fn in_a_curve(end_m: f64, radius_m: f64, places: &[Place]) -> Vec<Place> {
    let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
    let (sine, cosine) = libm::sincos(curve.curvature_perm * end_m);
    let (end_x_m, end_y_m) = curve.to_body(end_m, 0.0);
    let seen = places.iter().map(|&(along_m, off_m)| {
        let beyond_m = along_m - end_m;
        if beyond_m < 0.0 {
            return (along_m, off_m);
        }
        curve.to_way(
            end_x_m + beyond_m * cosine - off_m * sine,
            end_y_m + beyond_m * sine + off_m * cosine,
        )
    });
    seen.collect()
}

fn is_led_to(places: &[Place], place: Place) -> bool {
    leads_to(places.iter().copied(), place)
}

/// Those places that stand in the path straight ahead.
fn in_path(places: &[Place]) -> Vec<Place> {
    places.iter().copied().filter(|place| place.1.abs() < 1.9).collect()
}

fn row(first_m: f64, step_m: f64, off_m: f64) -> Vec<(f64, f64)> {
    (0..12).map(|k| (first_m + step_m * f64::from(k), off_m)).collect()
}

#[test]
fn a_queue_in_the_next_lane_of_a_curve_ahead_stands_beside_it() {
    for radius_m in [125.0, 250.0, 500.0, 1000.0] {
        for begin_m in [0.0, 20.0, 40.0] {
            let queue = row(5.0, 8.0, -3.5);
            let places = before_a_curve(begin_m, radius_m, &queue);
            let ahead = in_path(&places);
            assert!(radius_m > 500.0 || !ahead.is_empty(), "{radius_m} {begin_m}");
            for (along_m, off_m) in ahead {
                assert!(is_led_to(&places, (along_m, off_m)), "{radius_m} {begin_m} {along_m}");
            }
        }
    }
}

#[test]
fn the_same_on_the_other_side() {
    let places = before_a_curve(10.0, -125.0, &row(5.0, 8.0, 3.5));
    let ahead = in_path(&places);
    assert!(!ahead.is_empty() && ahead.iter().all(|(x, y)| is_led_to(&places, (*x, *y))));
}

#[test]
fn the_last_car_of_a_queue_beside_the_road_behind_a_curve_is_on_its_row() {
    for (radius_m, end_m) in [(125.0, 2.0), (-125.0, 2.0)] {
        let inner_m = 3.5 * f64::signum(radius_m);
        let places = in_a_curve(end_m, radius_m, &row(22.0, 7.5, inner_m));
        let last = places[0];
        assert!(last.1.abs() < 2.6, "{radius_m}: in the way, {last:?}");
        assert!(is_led_to(&places, (last.0, last.1)), "{radius_m} {places:?}");
    }
}

#[test]
fn a_queue_in_the_own_lane_is_no_such_row_on_an_arc_or_behind_it() {
    for radius_m in [125.0, -250.0, 500.0] {
        for end_m in [10.0, 30.0, 500.0] {
            for off_m in [-0.4, 0.0, 0.4] {
                let places = in_a_curve(end_m, radius_m, &row(25.0, 7.5, off_m));
                let last = places[0];
                if last.1.abs() < 1.9 {
                    let leads = is_led_to(&places, (last.0, last.1));
                    assert!(!leads, "{radius_m} {end_m} {off_m}");
                }
            }
        }
    }
}

#[test]
fn posts_of_a_curve_ahead_stand_beside_it() {
    for radius_m in [125.0, 250.0, 500.0] {
        for first_m in [4.0, 9.0, 14.0, 19.0] {
            let places = before_a_curve(0.0, radius_m, &row(first_m - 20.0, 20.0, -8.0));
            for (along_m, off_m) in in_path(&places) {
                assert!(is_led_to(&places, (along_m, off_m)), "{radius_m} {first_m} {along_m}");
            }
        }
    }
}

#[test]
fn a_queue_in_the_own_lane_is_no_row_from_beside_it() {
    for radius_m in [125.0, -250.0, 500.0, 1e9] {
        for begin_m in [0.0, 20.0, 60.0] {
            let mut standing = row(45.0, 7.5, 0.0);
            standing.extend(row(3.0, 20.0, -8.0));
            standing.extend(row(8.0, 20.0, 8.0));
            let places = before_a_curve(begin_m, radius_m, &standing);
            let (x_m, y_m) = {
                let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
                let beyond_m: f64 = 45.0 - begin_m;
                let (x_m, y_m) = curve.to_body(beyond_m.max(0.0), 0.0);
                (begin_m.min(45.0) + x_m, y_m)
            };
            if y_m.abs() < 1.9 {
                assert!(!is_led_to(&places, (x_m, y_m)), "{radius_m} {begin_m}");
            }
        }
    }
}

#[test]
fn queues_in_both_lanes_leave_the_nearest_car_of_the_own_one_in_the_way() {
    let mut standing = row(40.0, 7.5, 0.0);
    standing.extend(row(30.0, 7.5, -3.5));
    for radius_m in [250.0, -250.0, 1e9] {
        let places = before_a_curve(40.0, radius_m, &standing);
        assert!(!is_led_to(&places, (40.0, 0.0)), "{radius_m}");
    }
}
