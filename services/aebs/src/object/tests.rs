//! Hidden and shown sides and motion of an object, by places computed by hand.

use super::*;

/// A car, 4.3 m long, that stands at a place.
fn stands(distance_m: f64, off_m: f64) -> Object {
    Object::at(distance_m, 0.0, off_m, 0.0)
}

#[test]
fn it_is_seen_in_the_last_scans_or_in_more_of_a_radar_that_shows_little() {
    let seen = Object { history: 0b1_0000_1011, ..stands(40.0, 0.0) };
    for (scans, share, times) in [
        (4, 1.0, 3),
        (3, 1.0, 2),
        (8, 1.0, 3),
        (9, 1.0, 4),
        (4, 0.5, 3),
        (4, 0.45, 4),
        (4, 0.01, 4),
    ] {
        assert_eq!(seen.times_seen(scans, share), times, "{scans} {share}");
    }
}

#[test]
fn it_moves_on_and_stops_but_does_not_turn_round() {
    let moved = |speed_mps: f64, acceleration_mps2: f64, ego_mps: f64| {
        let mut object = Object { speed_mps, acceleration_mps2, ..stands(40.0, 0.0) };
        object.predict(0.5, ego_mps);
        (object.distance_m, object.speed_mps)
    };
    assert_eq!(moved(10.0, 2.0, 12.0), (40.0 + 5.25 - 6.0, 11.0));
    assert_eq!(moved(2.0, -8.0, 0.0), (40.5, 0.0));
    assert_eq!(moved(-3.0, -8.0, 4.0), (40.0 - 3.5, -3.0), "it comes towards the ego");
    let mut aside = Object::at(40.0, 10.0, 2.0, -1.0);
    aside.predict(0.05, 12.0);
    assert_eq!((aside.distance_m, aside.speed_mps), (39.9, 10.0));
    assert!((aside.lateral.position_m - 1.95).abs() < 2e-3, "{aside:?}");
}

#[test]
fn it_stands_below_a_metre_a_second() {
    for (speed_mps, expected) in [(0.99, true), (1.0, false), (-0.99, true), (-1.0, false)] {
        assert_eq!(Object { speed_mps, ..stands(40.0, 0.0) }.stands(), expected, "{speed_mps}");
    }
}

/// The field of view reaches a metre to the side in two.
#[test]
fn a_face_shows_where_its_nearer_corner_is_in_the_field_of_view() {
    let shows = |distance_m: f64, off_m: f64| stands(distance_m, off_m).shows_its_face(0.5);
    // It looks half a metre nearer than it is. It is 5 m to the side at 10.5 m, and the corner is 0.9 m nearer.
    assert!(shows(10.5, 5.8) && !shows(10.5, 6.0) && shows(10.5, -5.8) && !shows(10.5, -6.0));
    assert!(shows(0.6, 0.0) && !shows(0.5, 0.0) && !shows(-3.0, 0.0));
    // A way that bows to the left shows it there.
    let bowed = Object { bow_m: 1.0, ..stands(10.5, 4.8) };
    assert!(bowed.shows_its_face(0.5) && !Object { bow_m: 1.2, ..bowed }.shows_its_face(0.5));
}

#[test]
fn a_side_shows_beside_the_line_of_sight() {
    let shown = |object: Object| object.shown_side();
    // 0.9 m are half of what reflects, and 0.15 m more show the side.
    assert_eq!(shown(stands(40.0, 1.04)), None);
    let (side, shown_m) = shown(stands(40.0, 1.06)).expect("its right side");
    assert!(side == 1.0 && (shown_m - 0.16).abs() < 1e-6);
    let (side, shown_m) = shown(stands(40.0, -3.5)).expect("its left side");
    assert!(side == -1.0 && (shown_m + 2.6).abs() < 1e-6);
    // On a left curve a lead in the middle is right of the line of sight.
    let bend = |object: Object, bow_m: f64| {
        // Half of the turn is seen as a bow.
        Object { bow_m, road_rad: 2.0 * bow_m / object.distance_m, ..object }
    };
    let lead = bend(Object::at(40.0, 10.0, 0.0, 0.0), 3.0);
    let (side, shown_m) = shown(lead).expect("its left side");
    assert!(side == -1.0 && (shown_m - 0.9).abs() < 1e-6);
}

#[test]
fn a_corridor_bows_by_half_of_its_curvature_and_the_square_of_the_distance() {
    let mut object = stands(40.0, 0.0);
    object.see_along(&Corridor::circle(0.005, 0.0, 3e-4));
    assert!((object.bow_m - 4.0).abs() < 0.02, "{object:?}");
    assert!((object.road_rad - 0.2).abs() < 1e-9);
    assert!((object.way_sigma_m - 0.24).abs() < 1e-9);
}

#[test]
fn a_line_of_sight_is_hidden_by_a_body_that_it_passes_through() {
    let hides = |nearer: Object, x_m: f64, y_m: f64| {
        nearer.covers(x_m).is_some_and(|(right_m, left_m)| right_m < y_m && y_m < left_m)
    };
    // A body from 10 to 14.3 m, from -0.95 to 0.95 m.
    let nearer = stands(10.0, 0.0);
    assert!(hides(nearer, 30.0, 2.84) && !hides(nearer, 30.0, 2.86), "past its rear corner");
    assert!(hides(nearer, 30.0, -2.84) && !hides(nearer, 30.0, -2.86));
    // A place half way along it.
    assert!(hides(nearer, 12.0, 0.0) && !hides(nearer, 0.0, 0.0) && !hides(nearer, -5.0, 0.0));
    // A body beside the line is met where its nearer side ends.
    let beside = stands(10.0, 2.0);
    assert!(hides(beside, 30.0, 30.0 * 0.0735) && !hides(beside, 30.0, 30.0 * 0.0733));
    assert!(hides(beside, 30.0, 30.0 * 0.294) && !hides(beside, 30.0, 30.0 * 0.296));
    // One beside the ego, from the bumper to 2.3 m. At its end the line is to be 1.05 m to the side.
    assert!(hides(stands(-2.0, 2.0), 30.0, 13.8) && !hides(stands(-2.0, 2.0), 30.0, 13.6));
    assert_eq!(stands(-4.4, 0.0).covers(30.0), None, "it is passed");
}

/// Bounds of what other cars leave open of a car 30 m ahead.
fn open_m(off_m: f64, nearer: &[Object]) -> (f64, f64) {
    let mut object = stands(30.0, off_m);
    nearer.iter().for_each(|nearer| object.take_shadow(nearer));
    object.open_m
}

#[test]
fn a_nearer_object_hides_one_corner_both_or_none() {
    // The line to the left corner, 0.9 m at 30 m, is 0.3 m to the left at 10 m. The nearer one has a corner there at
    // 0.25 m, and behind it another one that is 14.3 m ahead.
    let edge_m = 0.25 * 30.0 / 14.3;
    let (right_m, left_m) = open_m(0.0, &[stands(10.0, 1.2)]);
    assert!(right_m == f64::NEG_INFINITY && (left_m - edge_m).abs() < 1e-6, "{left_m}");
    let (right_m, left_m) = open_m(0.0, &[stands(10.0, -1.2)]);
    assert!(left_m == f64::INFINITY && (right_m + edge_m).abs() < 1e-6, "{right_m}");
    assert_eq!(open_m(0.0, &[stands(10.0, 1.4)]), Object::OPEN_M, "beside all lines");
    assert_eq!(open_m(0.0, &[stands(10.0, 0.0)]), Object::OPEN_M, "all of it");
    // Not nearer by half a metre, or passed.
    assert_eq!(open_m(0.0, &[stands(29.6, 1.2)]), Object::OPEN_M);
    assert_eq!(open_m(0.0, &[stands(-8.4, 1.2)]), Object::OPEN_M);
}

#[test]
fn in_a_queue_beside_the_ego_the_inner_side_is_seen() {
    // Behind another car, both corners are in its shadow when the estimate is somewhat off.
    let (right_m, left_m) = open_m(3.5, &[stands(23.0, 3.4)]);
    assert!(right_m == f64::NEG_INFINITY && (left_m - 2.45 * 30.0 / 27.3).abs() < 1e-6, "{left_m}");
    assert_eq!(open_m(3.9, &[stands(23.0, 2.9)]).0, f64::NEG_INFINITY);
}

#[test]
fn of_two_shadows_the_larger_one_counts_on_each_side() {
    let alone = |nearer: Object| open_m(0.0, &[nearer]);
    let (wide, narrow) = (stands(10.0, 1.15), stands(10.0, 1.2));
    assert!(alone(wide).1 < alone(narrow).1);
    assert_eq!(open_m(0.0, &[narrow, wide]), alone(wide));
    assert_eq!(open_m(0.0, &[wide, narrow]), alone(wide));
    let right = stands(10.0, -1.2);
    assert_eq!(open_m(0.0, &[wide, right]), (alone(right).0, alone(wide).1));
}

#[test]
fn an_object_begins_unconfirmed_with_a_cars_size() {
    let begun = Object::begin(40.0, 1.0, 12.0);
    assert_eq!((begun.distance_m, begun.speed_mps, begun.length_m), (40.0, 12.0, 4.3));
    assert_eq!(begun.lateral.position_m, 1.0);
    assert!(!begun.is_confirmed && begun.history == 0 && begun.is_seen);
    assert!((begun.lateral.position_sigma_m() - 0.7).abs() < 1e-9);
}
