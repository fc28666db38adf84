//! The points of one scan together, computed by hand.

use super::*;

fn point(x_m: f64, y_m: f64) -> Point {
    Point { x_m, y_m, speed_mps: 10.0, tangent: 0.0, variance_m2: 0.01, speed_variance: 0.01 }
}

#[track_caller]
fn assert_near(found: Option<(f64, f64)>, expected: (f64, f64)) {
    let (a, b) = found.expect("it is known");
    assert!((a - expected.0).abs() < 1e-9 && (b - expected.1).abs() < 1e-9, "{a} {b}");
}

#[test]
fn a_side_says_where_the_middle_is() {
    // The right side of a car 3.5 m to the left, at 2.6 m.
    for side in [1.0, -1.0] {
        let object = Object::at(20.0, 10.0, side * 3.5, 0.0);
        let seen = [point(21.0, side * 2.6), point(22.0, side * 2.7)];
        // 0.1 m of each of the two, 0.03 m of the places that reflect, and 0.0025 rad at 20 m.
        assert_near(lateral(&object, &seen, false), (side * 3.55, 0.005 + 0.0009 + 0.0025));
        // A point that is too far off for the side, or too near to the face, is of another part.
        for other in [point(22.0, side * 2.95), point(20.4, side * 2.6)] {
            let more = [seen[0], seen[1], other];
            assert_near(lateral(&object, &more, false), (side * 3.55, 0.0084));
        }
    }
    let ahead = Object::at(20.0, 10.0, 0.0, 0.0);
    assert_eq!(lateral(&ahead, &[point(22.0, 0.9)], false), None);
    // A nearer vehicle hides the side up to 2.7 m: what is seen there is of another part.
    let shaded = Object { open_m: (2.7, f64::INFINITY), ..Object::at(20.0, 10.0, 3.5, 0.0) };
    assert_eq!(lateral(&shaded, &[point(21.0, 2.6)], false), None);
}

#[test]
fn a_face_says_it_by_its_outermost_points() {
    let object = Object::at(20.0, 10.0, 0.0, 0.0);
    let merged = [point(20.0, -0.15), point(20.2, 0.1), point(19.9, 0.2)];
    // 0.3 m at most, and 0.0025 rad at 20 m.
    assert_near(lateral(&object, &merged, true), (0.025, 0.09 + 0.0025));
    assert_eq!(lateral(&object, &merged, false), None, "it is out of sight");
    // A strip of 0.8 m is seen beside a shadow. The middle of the body is 0.5 m farther into it.
    for side in [1.0, -1.0] {
        let expected = (0.025 + side * 0.5, 0.0925 + 0.25 / 12.0);
        let open_m = |edge_m: f64| match side > 0.0 {
            true => (f64::NEG_INFINITY, edge_m),
            false => (edge_m, f64::INFINITY),
        };
        let shaded = Object { open_m: open_m(0.025 + side * 0.4), ..object };
        assert_near(lateral(&shaded, &merged, true), expected);
        // The shadow ends beyond the body.
        let shaded = Object { open_m: open_m(0.025 + side * 1.1), ..object };
        assert_near(lateral(&shaded, &merged, true), (0.025, 0.0925));
    }
    let corners = [point(20.0, -0.8), point(20.0, 0.9)];
    assert_near(lateral(&object, &corners, true), (0.05, 0.01 + 0.0025));
    // 0.6 m of its 1.8 m are open.
    let wide = [point(20.0, -0.5), point(20.0, 0.7)];
    assert_near(lateral(&object, &wide, true), (0.1, 0.36 / 12.0 + 0.0025));
    // Side and face together, by their weights.
    let beside = Object::at(20.0, 10.0, 3.5, 0.0);
    let both = [point(22.0, 2.7), point(20.0, 3.3)];
    let (side, face) = (1.0 / (0.01 + 0.0009), 1.0 / 0.09);
    let expected = ((side * 3.6 + face * 3.3) / (side + face), 1.0 / (side + face) + 0.0025);
    assert_near(lateral(&beside, &both, true), expected);
}

#[test]
fn the_face_is_the_mean_of_its_points_or_where_it_was_missed() {
    let object = Object::at(20.0, 10.0, 0.0, 0.0);
    let found_m = |places: &[f64]| {
        let points: Vec<Point> = places.iter().map(|x_m| point(*x_m, 0.0)).collect();
        face_m(&object, &points)
    };
    assert_eq!(found_m(&[20.0, 20.5, 19.5, 21.0, 23.0]), Some(20.0));
    assert_eq!(found_m(&[19.0, 18.9, 22.0]), Some(18.95));
    assert_eq!(found_m(&[21.3, 18.7]), None);
}

#[test]
fn a_lateral_speed_is_the_slope_of_the_speeds_over_the_tangents() {
    let at = |tangent: f64, speed_mps: f64| Point { tangent, speed_mps, ..point(20.0, 0.0) };
    let slope = |points: &[Point]| lateral_rate(points);
    // Two points with a weight of 100 each: the information is 100 · 0.2² / 2.
    assert_near(slope(&[at(0.0, 10.0), at(0.2, 10.2)]), (1.0, 0.5 + 0.01));
    assert_near(slope(&[at(0.1, 10.0), at(0.3, 9.8)]), (-1.0, 0.51));
    assert_eq!(slope(&[at(0.0, 10.0), at(0.03, 10.0)]), None, "in one direction");
    assert_eq!(slope(&[at(0.2, 10.0)]), None);
}

#[test]
fn a_scan_corrects_speed_acceleration_place_and_length() {
    let mut object = Object::at(20.0, 10.0, 0.0, -1.0);
    let faster = Point { speed_mps: 10.9, tangent: 0.1, ..point(20.4, 0.0) };
    let far = Point { speed_mps: 11.1, tangent: -0.1, ..point(25.0, 0.0) };
    // An object that moves to the right with 1 m/s looks 0.1 m/s slower on the left: 11.0 and 11.0
    // m/s.
    let points = [faster, far];
    correct(&mut object, &points, 0.05, true, 1.0);
    assert!((object.speed_mps - 10.6).abs() < 1e-6, "{object:?}");
    // 0.6 m/s in 0.05 s are 12 m/s², of which a fifth is taken.
    assert!((object.acceleration_mps2 - 2.4).abs() < 1e-4, "{object:?}");
    assert!((object.distance_m - 20.2).abs() < 1e-9, "half of the way");
    assert!((object.length_m - 5.9).abs() < 1e-9, "{object:?}");
    assert_eq!(object.unseen_s, 0.0);
    // Without its face the distance stays, and the first scan is taken as it is.
    let mut hidden = Object::at(20.0, 10.0, 0.0, 0.0);
    correct(&mut hidden, &points, 0.05, false, 1.0);
    assert_eq!(hidden.distance_m, 20.0);
    let mut new = Object::begin(20.0, 0.0, 10.0);
    correct(&mut new, &points, 0.05, false, 1.0);
    assert!((new.distance_m - 20.4).abs() < 1e-9 && (new.speed_mps - 11.0).abs() < 1e-6);
    assert_eq!(new.acceleration_mps2, 0.0);
    // No vehicle accelerates or brakes beyond its limits.
    for (speed_mps, limit_mps2) in [(10.0, 5.0), (60.0, -10.0)] {
        let mut wild = Object::at(20.0, speed_mps, 0.0, 0.0);
        let speed_mps = if limit_mps2 > 0.0 { 60.0 } else { 10.0 };
        let jump = Point { speed_mps, ..point(20.0, 0.0) };
        correct(&mut wild, &[jump], 0.05, true, 1.0);
        assert_eq!(wild.acceleration_mps2, limit_mps2);
    }
}

#[test]
fn a_moving_object_counts_after_three_of_four_scans_and_a_standing_one_after_four_of_five() {
    let counts = |speed_mps: f64, seen: &[bool]| {
        let mut object = Object::begin(20.0, 0.0, speed_mps);
        for is_seen in seen {
            object.history <<= 1;
            let points = [Point { speed_mps, ..point(20.0, 0.0) }];
            let seen = if *is_seen { &points[..] } else { &[] };
            correct(&mut object, seen, 0.05, true, 1.0);
        }
        object.is_confirmed
    };
    assert!(
        counts(10.0, &[true, false, true, true])
            && !counts(10.0, &[true, true, false, false, true])
    );
    assert!(counts(0.0, &[true, true, false, true, true]));
    assert!(!counts(0.0, &[true, false, true, true]));
    assert!(!counts(0.0, &[true, true, true, false, false, true]));
}
