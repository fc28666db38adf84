use super::*;

/// A point of a good detection.
pub(in super::super) fn point(x_m: f64, y_m: f64, range_rate_mps: f64) -> Point {
    Point {
        x_m,
        y_m,
        direction: (1.0, 0.0),
        aspect_m: y_m,
        range_rate_mps,
        range_variance: 0.01,
        range_rate_variance: 0.01,
        lateral_variance: 0.04,
        ground_speed_mps: 20.0 + range_rate_mps,
        half_width_m: 0.0,
        detection: 0,
        vehicle: None,
        owner: None,
    }
}

fn outline(rear_m: f64, lateral_m: f64) -> Outline {
    Outline {
        vehicle: None,
        confirmed: true,
        rear_m,
        lateral_m,
        aspect_m: lateral_m,
        length_m: 4.5,
        half_width_m: 0.9,
        relative_speed_mps: 0.0,
        lateral_speed_mps: 0.0,
        variances: [0.1, 0.05, 0.05, 0.1],
    }
}

fn owners(points: &[Point], outlines: &[Outline]) -> Vec<Option<usize>> {
    let mut points = points.to_vec();
    associate(&mut points, outlines, 5.0, &Numbers::DEFAULT);
    points.iter().map(|point| point.owner).collect()
}

#[test]
fn a_track_takes_all_echoes_of_its_vehicle() {
    let points = [point(40.0, 0.8, 0.1), point(40.2, -0.9, 0.0), point(44.0, 0.9, -0.1)];
    assert_eq!(owners(&points, &[outline(40.0, 0.0)]), [Some(0); 3]);
}

#[test]
fn between_two_vehicles_the_nearer_gets_the_echo() {
    let outlines = [outline(40.0, 0.0), outline(40.0, 3.5)];
    let points = [point(40.0, 0.9, 0.0), point(40.0, 2.5, 0.0), point(40.0, 3.4, 0.0)];
    assert_eq!(owners(&points, &outlines), [Some(0), Some(1), Some(1)]);
}

#[test]
fn an_echo_elsewhere_or_of_another_motion_belongs_to_no_track() {
    let points = [point(30.0, 0.0, 0.0), point(40.0, 4.0, 0.0), point(40.0, 0.0, -5.0)];
    assert_eq!(owners(&points, &[outline(40.0, 0.0)]), [None; 3]);
}

#[test]
fn a_track_between_two_vehicles_keeps_one_of_them() {
    let mut points = [point(40.0, 2.7, 0.0), point(40.0, -2.7, 0.0), point(40.0, 3.0, 0.0)];
    points.iter_mut().for_each(|point| point.owner = Some(3));
    part(&mut points, 3, 0.5, &Numbers::DEFAULT);
    assert_eq!(points.map(|point| point.owner), [Some(3), None, Some(3)]);
    // The two sides of a lorry are one vehicle's.
    let mut lorry = [point(40.0, 1.3, 0.0), point(40.0, -1.3, 0.0)];
    lorry.iter_mut().for_each(|point| point.owner = Some(3));
    part(&mut lorry, 3, 0.0, &Numbers::DEFAULT);
    assert_eq!(lorry.map(|point| point.owner), [Some(3); 2]);
}

/// The distance of a point from a car whose rear is 40 m ahead.
fn distance(point: Point) -> Option<f64> {
    outline(40.0, 0.0).distance(&point, 4.0, &Numbers::DEFAULT)
}

#[track_caller]
fn assert_distance(found: Option<f64>, expected: f64) {
    assert!(found.is_some_and(|found| (found - expected).abs() < 1e-9), "{found:?} {expected}");
}

#[test]
fn a_distance_is_in_deviations_of_rear_sides_and_speed() {
    // Along: 0.1 of the track, 0.01 of the point and 0.3² of the body. Across: 0.05, 0.04 and 0.3².
    assert_distance(distance(point(42.0, 0.5, 0.0)), 0.0);
    assert_distance(distance(point(39.0, 0.0, 0.0)), 1.0 / 0.2);
    assert_distance(distance(point(40.0, 1.4, 0.0)), 0.25 / 0.18);
    assert_distance(distance(point(40.0, -1.4, 0.0)), 0.25 / 0.18);
    // Behind the length of 4.5 m are 2.5 m in which echoes from below arrive.
    assert_distance(distance(point(47.0, 0.0, 0.0)), 0.0);
    assert_distance(distance(point(48.0, 0.0, 0.0)), 1.0 / 0.2);
    // Three deviations are the gate of a place.
    assert_distance(distance(point(38.7, 0.0, 0.0)), 1.69 / 0.2);
    assert_eq!(distance(point(38.6, 0.0, 0.0)), None);
    assert_eq!(distance(point(40.0, 2.2, 0.0)), None);
    // The speed: 0.05 and 0.01.
    assert_distance(distance(point(40.0, 0.0, -0.6)), 0.36 / 0.06);
    assert_eq!(distance(point(40.0, 0.0, -1.0)), None, "beyond four deviations");
}

#[test]
fn across_the_line_of_sight_the_lateral_speed_counts() {
    let moving = Outline { relative_speed_mps: 0.2, lateral_speed_mps: 0.1, ..outline(40.0, 0.0) };
    let aside = Point { direction: (0.8, 0.6), ..point(40.0, 0.0, 0.5) };
    // 0.2 · 0.8 + 0.1 · 0.6 are expected; 0.1 · 0.6² of the lateral speed add to 0.05 and 0.01.
    let numbers = &Numbers::DEFAULT;
    assert_distance(moving.distance(&aside, 4.0, numbers), 0.28 * 0.28 / 0.096);
    let tentative = Outline { confirmed: false, ..moving };
    assert_distance(tentative.distance(&aside, 4.0, numbers), 4.0 + 0.28 * 0.28 / 0.096);
}

#[test]
fn along_the_side_that_shows_echoes_come_from_farther() {
    let aside = outline(40.0, 5.0);
    let at = |x_m: f64, y_m: f64| aside.distance(&point(x_m, y_m, 0.0), 4.0, &Numbers::DEFAULT);
    // Its right side, at 4.1 m, looks at the ego.
    assert_distance(at(50.5, 4.1), 0.0);
    assert_distance(at(51.5, 4.1), 1.0 / 0.2);
    let ahead = Outline { aspect_m: 0.0, ..aside };
    assert_eq!(ahead.distance(&point(50.5, 4.1, 0.0), 4.0, &Numbers::DEFAULT), None);
}

#[test]
fn a_confirmed_track_keeps_its_echoes_from_a_new_one() {
    let tentative = Outline { confirmed: false, ..outline(40.0, 0.0) };
    let points = [point(39.5, 0.0, 0.0)];
    assert_eq!(owners(&points, &[tentative, outline(40.0, 0.0)]), [Some(1)]);
}
