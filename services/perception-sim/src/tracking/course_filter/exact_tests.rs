//! Single steps of the filter, with the numbers that follow by hand.

use super::*;

mod sources_tests;

const POSTS: Sources =
    Sources { yaw_rate: true, standing: true, trails: false, map: false, as_belief: false };
const NUMBERS: CourseNumbers = CourseNumbers::DEFAULT;

/// A filter whose state has these variances, on a straight course.
fn known(sources: Sources, mean: [f64; STATES], variances: [f64; STATES]) -> CourseFilter {
    let state = Gaussian::independent(mean, variances);
    CourseFilter { state, ..CourseFilter::new(sources, &NUMBERS) }
}

/// The variances of a state of which these entries are not known.
fn unsure(entries: &[(usize, f64)]) -> [f64; STATES] {
    let mut variances = [0.0; STATES];
    entries.iter().for_each(|&(entry, sigma)| variances[entry] = sigma * sigma);
    variances
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{found} {expected}");
}

/// Heading, and curvatures that grow by `rate` over a metre.
fn linear(heading: f64, curvature: f64, rate: f64) -> [f64; STATES] {
    from_fn(|i| if i == 0 { heading } else { curvature + rate * APART_M * (i - 1) as f64 })
}

#[test]
fn a_clothoid_is_reported_as_it_is() {
    let filter = known(POSTS, linear(0.02, 1e-3, 1e-5), [0.0; STATES]);
    let [heading, curvature, rate] = filter.clothoid();
    assert_near(heading, 0.02);
    assert_near(curvature, 1e-3);
    assert_near(rate, 1e-5);
    // The same begins 10 m farther.
    let passed = CourseFilter { passed_m: 10.0, ..filter };
    assert_near(passed.clothoid()[1], 1.1e-3);
    let unused = known(Sources::default(), linear(0.02, 1e-3, 1e-5), [0.0; STATES]);
    assert_eq!(unused.clothoid(), [0.0; 3]);
}

#[test]
fn deviations_grow_with_the_distance() {
    let heading = known(POSTS, [0.0; STATES], unsure(&[(0, 0.01)]));
    assert_near(heading.sigma_m(50.0), 0.5);
    assert_near(heading.path_sigma_m(50.0), 0.5);
    assert_near(heading.heading_sigma_rad(50.0), 0.01);
    // The first knot's hat falls over 25 m: its integral is 12.5 m, the integral of that 25²/3 m².
    let knot = known(POSTS, [0.0; STATES], unsure(&[(1, 1e-3)]));
    assert_near(knot.heading_sigma_rad(25.0), 0.0125);
    assert_near(knot.sigma_m(25.0), 0.625 / 3.0);
    let circle = Sources { yaw_rate: true, ..Sources::default() };
    let circle = known(circle, [0.0; STATES], unsure(&[(0, 0.01)]));
    assert_eq!((circle.sigma_m(50.0) > 0.4, circle.path_sigma_m(50.0)), (true, 0.0));
    let unused = known(Sources::default(), [0.0; STATES], unsure(&[(0, 0.01)]));
    assert_eq!((unused.sigma_m(50.0), unused.heading_sigma_rad(50.0)), (0.0, 0.0));
}

#[test]
fn the_heading_changes_by_the_road_less_the_own_turn() {
    let motion = |yaw_rate_radps| Motion { speed_mps: 25.0, yaw_rate_radps, slip_rad: 0.0 };
    let after = |yaw_rate_radps| {
        let mut filter = known(POSTS, linear(0.0, 2e-3, 0.0), [0.0; STATES]);
        filter.advance(0.05, &motion(yaw_rate_radps));
        filter.state.mean[0]
    };
    // 1.25 m of a curve of 2e-3 1/m.
    assert_near(after(Some(0.0)), 2.5e-3);
    assert_near(after(Some(0.02)), 1.5e-3);
    assert_near(after(None), 0.0);
}

#[test]
fn curvatures_fade_on_the_way_and_a_new_knot_is_less_sharp() {
    let mut filter = known(POSTS, from_fn(|i| i as f64 * 1e-3), unsure(&[(3, 1e-3), (8, 2e-3)]));
    filter.fade(4.0, 2.0);
    let faded = square(2.0 * NUMBERS.curvature_perm) * 4.0;
    assert_near(filter.state.covariance[1][1], faded);
    assert_near(filter.state.covariance[3][3], 1e-6 + faded);
    assert_eq!(filter.state.covariance[0][0], 0.0);
    filter.passed_m = 26.0;
    filter.pass_knot(1.0);
    assert_near(filter.passed_m, 1.0);
    let mean = filter.state.mean;
    assert_eq!((mean[0], mean[1], mean[7]), (0.0, 2e-3, 8e-3));
    assert_near(mean[8], 0.8 * 8e-3);
    let p = &filter.state.covariance;
    assert_near(p[2][2], 1e-6 + faded);
    assert_near(p[7][7], 4e-6 + faded);
    assert_near(p[7][8], 0.8 * (4e-6 + faded));
    assert_near(p[8][8], 0.64 * (4e-6 + faded) + square(NUMBERS.change_perm));
}

#[test]
fn a_residual_counts_against_the_state_of_the_scan() {
    let (before, mut h) = ([0.0; STATES], [0.0; STATES]);
    h[0] = 40.0;
    let mut moved = before;
    moved[0] = 1e-3;
    let filter = known(POSTS, moved, unsure(&[(0, 0.01)]));
    // The state has moved as far as the residual.
    let mut seen = filter;
    assert!(seen.see_from(&before, h, 0.04, 0.3));
    assert_near(seen.state.mean[0], 1e-3);
    // 0.1 m are left; 0.16 m² of 0.25 m² are the heading's.
    let mut seen = filter;
    assert!(seen.see_from(&before, h, 0.14, 0.3));
    assert_near(seen.state.mean[0], 1e-3 + 0.1 / 40.0 * 0.16 / 0.25);
    // The gate is 4 · 0.5 m.
    let mut seen = filter;
    assert!(!seen.see_from(&before, h, 2.05, 0.3));
    assert_eq!(seen.state, filter.state);
}

/// Takes in one object.
fn stand(filter: &mut CourseFilter, x_m: f64, y_m: f64) {
    let before = filter.state.mean;
    filter.take_standing(&before, &[(x_m, y_m)]);
}

#[test]
fn an_edge_is_the_mean_of_its_objects_and_counts_after_some_scans() {
    let mut filter = known(POSTS, [0.0; STATES], [0.0; STATES]);
    for k in 0..24 {
        stand(&mut filter, 30.0, if k % 2 == 0 { 8.5 } else { 9.5 });
        stand(&mut filter, 30.0, -7.0);
        assert_eq!(filter.posts, 0, "too few at {k}");
    }
    assert_eq!(filter.edges.known().map(|(_, objects)| objects), [24, 24]);
    assert_near(filter.edges.known()[0].0, 9.0);
    assert_near(filter.edges.known()[1].0, -7.0);
    stand(&mut filter, 30.0, 9.0);
    assert_eq!((filter.posts, filter.edges.known()[0].1), (1, 25));
    // Farther than 60 m it is of the edge, and does not teach it.
    stand(&mut filter, 70.0, 10.0);
    assert_eq!((filter.posts, filter.edges.known()[0].1), (1, 25));
    // More than 2 m beside the edge it is something else.
    stand(&mut filter, 30.0, 11.1);
    assert_eq!((filter.posts, filter.edges.known()[0].1), (0, 25));
    stand(&mut filter, 30.0, 10.9);
    assert_eq!((filter.posts, filter.edges.known()[0].1), (1, 26));
}

#[test]
fn the_first_object_of_an_edge_is_neither_in_the_next_lane_nor_far_off() {
    for (y_m, objects) in [(4.9, 0), (5.0, 1), (19.9, 1), (20.1, 0), (-4.9, 0), (-6.0, 1)] {
        let mut filter = known(POSTS, [0.0; STATES], [0.0; STATES]);
        stand(&mut filter, 30.0, y_m);
        assert_eq!(filter.edges.known()[usize::from(y_m < 0.0)].1, objects, "{y_m}");
    }
    // Three deviations of the course at 30 m. 5.9 m and the object's own 2 m are less than 8 m; 6.1 m are more.
    for (sigma_m, objects) in [(5.9 / 3.0, 1), (6.1 / 3.0, 0)] {
        let mut filter = known(POSTS, [0.0; STATES], unsure(&[(0, sigma_m / 30.0)]));
        stand(&mut filter, 30.0, 9.0);
        assert_eq!(filter.edges.known()[0].1, objects, "{sigma_m}");
    }
}

#[test]
fn an_object_beyond_its_edge_turns_the_course_to_it() {
    let mut filter = known(POSTS, [0.0; STATES], unsure(&[(0, 0.01)]));
    filter.edges = filter.edges.with_left(9.0, 30);
    stand(&mut filter, 40.0, 9.5);
    // 0.9 m in each of 25 scans, and 0.0044 rad at 40 m.
    let noise = 0.81 * 25.0 + 0.176 * 0.176;
    assert_near(filter.state.mean[0], 1e-4 * 40.0 * 0.5 / (0.16 + noise));
    assert_near(filter.edges.known()[0].0, 9.0 + 0.5 / 31.0);
    // Many objects have an edge that an object moves by a fiftieth.
    filter = known(POSTS, [0.0; STATES], [0.0; STATES]);
    filter.edges = filter.edges.with_left(9.0, 100);
    stand(&mut filter, 40.0, 9.5);
    assert_near(filter.edges.known()[0].0, 9.01);
}

#[test]
fn a_scan_takes_sixteen_objects_at_most() {
    let mut filter = known(POSTS, [0.0; STATES], [0.0; STATES]);
    filter.edges = filter.edges.with_left(9.0, 30);
    let many: Vec<(f64, f64)> = (0..20).map(|k| (20.0 + f64::from(k), 9.0)).collect();
    let before = filter.state.mean;
    filter.take_standing(&before, &many);
    assert_eq!(filter.used(), (16, 0));
}

#[test]
fn the_map_is_read_between_its_cells() {
    let map = Sources { map: true, ..Sources::default() };
    let mut filter = known(map, [0.0; STATES], unsure(&[(1, 1e-3)]));
    // 2e-3 1/m at the ego: half way between the middles of the first two cells.
    let curvatures_perm = &[1e-3, 3e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    filter.take_map(&MapAhead { curvatures_perm, first_m: -10.0, cell_m: 20.0 });
    // The state and the map are equally sure of it.
    assert_near(filter.state.mean[1], 1e-3);
    assert_eq!(filter.state.mean[2..], [0.0; KNOTS - 1]);
}

/// The deviations of the course 20 and 100 m ahead.
fn deviations(filter: &CourseFilter) -> [f64; 2] {
    [filter.sigma_m(20.0), filter.sigma_m(100.0)]
}

#[test]
fn an_own_turn_beyond_the_gate_forgets_the_road_and_one_within_it_does_not() {
    let sources = Sources { yaw_rate: true, ..POSTS };
    let variances = from_fn(|i| if i == 0 { 1e-6 } else { 1e-8 });
    let turned = |curvature_perm: f64| {
        let mut filter = known(sources, [0.0; STATES], variances);
        let motion =
            Motion { speed_mps: 20.0, yaw_rate_radps: Some(20.0 * curvature_perm), slip_rad: 0.0 };
        filter.take(&motion, None, &[]);
        filter
    };
    // Four deviations of the curvature, 1e-4 1/m, and of the own way, 3e-4 1/m, are 1.26e-3 1/m.
    let [(within, far), (beyond, forgotten)] =
        [1.2e-3, 1.3e-3].map(|turn_perm| (turned(turn_perm), deviations(&turned(turn_perm))[1]));
    assert!(within.course().curvature_perm(0.0) < 2e-4, "{:?}", within.state.mean);
    assert!((beyond.course().curvature_perm(0.0) - 1.3e-3).abs() < 2e-4, "{:?}", beyond.state.mean);
    assert!(forgotten > 4.0 * far, "{forgotten} m, {far} m");
}
