//! The course against circles and clothoids, whose places follow by hand.

use super::*;

/// A left curve whose radius is as small as the arc of a roundabout's exit. So each term of a series shows.
const RADIUS_M: f64 = 20.0;

fn circle() -> Course {
    Course::bent(0.0, |_| 1.0 / RADIUS_M)
}

#[track_caller]
fn assert_within(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found} for {expected}");
}

#[test]
fn a_turn_is_that_of_cosine_and_sine() {
    let node = Node { cosine: libm::cos(0.3), sine: libm::sin(0.3), ..Node::default() };
    for turn_rad in [0.2, -0.2, 0.0] {
        let (cosine, sine) = node.turned(turn_rad);
        assert_within(cosine, libm::cos(0.3 + turn_rad), 2e-7);
        assert_within(sine, libm::sin(0.3 + turn_rad), 2e-7);
    }
    let along_x = Node { cosine: 1.0, ..Node::default() };
    assert_within(along_x.turned(0.2).0, libm::cos(0.2), 1.2e-7);
    assert_within(along_x.turned(0.2).1, libm::sin(0.2), 4e-9);
}

#[test]
fn a_place_on_a_circle_is_where_the_circle_has_it() {
    for (sigma_m, d_m) in [(3.5, 0.0), (3.5, 3.0), (-3.5, -3.0), (2.0, -2.5)] {
        let (sine, cosine) = libm::sincos(sigma_m / RADIUS_M);
        let (x_m, y_m) = circle().place(sigma_m, d_m);
        assert_within(x_m, (RADIUS_M - d_m) * sine, 5e-8);
        assert_within(y_m, RADIUS_M - (RADIUS_M - d_m) * cosine, 2e-7);
    }
}

#[test]
fn a_point_beside_a_circle_is_located_by_its_angle_and_radius() {
    for (sigma_m, d_m) in [(3.5, 0.0), (3.5, 3.0), (-3.5, -3.0), (2.0, -2.5)] {
        let (sine, cosine) = libm::sincos(sigma_m / RADIUS_M);
        let there = circle().locate((RADIUS_M - d_m) * sine, RADIUS_M - (RADIUS_M - d_m) * cosine);
        // The angle's series ends before the seventh power of 0.225, where the next node is found first: 3.5e-5 m.
        assert_within(there.sigma_m, sigma_m, 4e-5);
        assert_within(there.d_m, d_m, 1e-5);
        assert_within(there.tangent.0, cosine, 5e-6);
        assert_within(there.tangent.1, sine, 5e-6);
        assert_eq!(there.curvature_perm, 1.0 / RADIUS_M);
    }
}

#[test]
fn nodes_are_places_of_the_clothoid() {
    let shape = [0.02, 2e-3, 5e-5];
    let course = Course::bent(shape[0], |sigma_m| shape[1] + shape[2] * sigma_m);
    let heading = |s: f64| shape[0] + s * (shape[1] + 0.5 * shape[2] * s);
    let (mut x_m, mut y_m, step_m) = (0.0, 0.0, 0.001);
    for index in 0..14 {
        let from_m = 8.0 * f64::from(index);
        let node = &course.nodes[index as usize];
        assert_within(node.x_m, x_m, 2e-5);
        assert_within(node.y_m, y_m, 2e-5);
        assert_within(node.sine, libm::sin(heading(from_m)), 1e-12);
        assert_within(node.cosine, libm::cos(heading(from_m)), 1e-12);
        assert_within(node.curvature_perm, shape[1] + shape[2] * from_m, 1e-15);
        for step in 0..8000 {
            let rad = heading(from_m + step_m * (f64::from(step) + 0.5));
            (x_m, y_m) = (x_m + step_m * libm::cos(rad), y_m + step_m * libm::sin(rad));
        }
    }
}

#[test]
fn a_curvature_is_linear_between_nodes_and_constant_beyond_the_ends() {
    let course = Course::bent(0.0, |sigma_m| 1e-3 + 1e-5 * sigma_m);
    for (sigma_m, perm) in [
        (0.0, 1e-3),
        (12.0, 1.12e-3),
        (78.0, 1.78e-3),
        (183.0, 2.83e-3),
        (-9.0, 1e-3),
        (400.0, 2.84e-3),
    ] {
        assert_within(course.curvature_perm(sigma_m), perm, 1e-15);
    }
}

#[test]
fn beyond_both_ends_the_course_is_a_line() {
    let course = circle();
    let there = course.locate(-12.0, 2.5);
    assert_eq!((there.sigma_m, there.d_m, there.tangent), (-12.0, 2.5, (1.0, 0.0)));
    assert_eq!(course.place(-12.0, 2.5), (-12.0, 2.5));
    assert_eq!(course.tangent(-12.0), (1.0, 0.0));
    // The last node is 184 m ahead.
    let last = &course.nodes[NODES - 1];
    let (x_m, y_m) = course.place(200.0, 1.0);
    assert_within(x_m, last.x_m + 16.0 * last.cosine - last.sine, 1e-12);
    assert_within(y_m, last.y_m + 16.0 * last.sine + last.cosine, 1e-12);
    assert_eq!(course.tangent(200.0), (last.cosine, last.sine));
    // Eight metres behind the bumper the arc ends.
    assert_within(course.tangent(-7.9).1, -libm::sin(7.9 / RADIUS_M), 2e-5);
    assert_eq!(course.tangent(-8.1).1, 0.0);
}

#[test]
fn a_heading_is_that_of_the_circle_at_its_arc_length() {
    let course = Course::bent(0.1, |_| 1.0 / 200.0);
    for sigma_m in [0.0, 5.0, 43.0, 90.0] {
        let (cosine, sine) = course.tangent(sigma_m);
        assert_within(cosine, libm::cos(0.1 + sigma_m / 200.0), 1e-9);
        assert_within(sine, libm::sin(0.1 + sigma_m / 200.0), 1e-9);
    }
    assert_eq!((course.heading_rad, course.is_straight), (0.1, false));
    assert_eq!(Course::STRAIGHT.tangent(43.0), (1.0, 0.0));
}
