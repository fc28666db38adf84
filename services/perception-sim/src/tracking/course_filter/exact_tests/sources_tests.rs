//! Effect of each source and of the way on the state, with numbers computed by hand.

use super::*;

const YAW_RATE: Sources =
    Sources { yaw_rate: true, standing: false, trails: false, map: false, as_belief: false };
const TRAILS: Sources =
    Sources { yaw_rate: false, standing: false, trails: true, map: false, as_belief: false };

fn moving(speed_mps: f64, yaw_rate_radps: Option<f64>, slip_rad: f64) -> Motion {
    Motion { speed_mps, yaw_rate_radps, slip_rad }
}

#[test]
fn before_the_first_scan_neighbouring_knots_are_much_alike() {
    let p = CourseFilter::new(POSTS, &NUMBERS).state.covariance;
    assert_near(p[0][0], 1e-4);
    assert_eq!((p[0][1], p[3][0]), (0.0, 0.0));
    for (a, b, share) in [(1, 1, 1.0), (1, 2, 0.8), (4, 2, 0.64), (1, 8, libm::pow(0.8, 7.0))] {
        assert_near(p[a][b], 1e-6 * share);
    }
    // The yaw rate alone makes a circle: all knots are one.
    let circle = CourseFilter::new(YAW_RATE, &NUMBERS).state.covariance;
    assert!(circle[1..].iter().flat_map(|row| &row[1..]).all(|entry| *entry == 1e-6));
}

#[test]
fn the_ego_turns_as_its_way_does_as_far_as_its_driver_keeps_to_it() {
    let after = |motion: Motion| {
        let mut filter = known(YAW_RATE, [0.0; STATES], unsure(&[(0, 0.01), (1, 1e-3)]));
        filter.take(&motion, None, &[]);
        (filter.state.mean[0], filter.state.mean[1])
    };
    // 0.02 rad/s at 20 m/s are 1e-3 1/m, to 3e-4 1/m; the slip angle shows the heading to 0.012 rad.
    let (of_way, of_angle) = (1e-6 / (1e-6 + 9e-8), 1e-4 / (1e-4 + 1.44e-4));
    let (heading, curvature) = after(moving(20.0, Some(0.02), 0.006));
    assert_near(heading, 0.006 * of_angle);
    assert_near(curvature, 1e-3 * of_way);
    // Four deviations of the difference count at most.
    let (heading, curvature) = after(moving(20.0, Some(-0.2), 0.1));
    assert_near(heading, 4.0 * f64::sqrt(2.44e-4) * of_angle);
    assert_near(curvature, -4.0 * f64::sqrt(1.09e-6) * of_way);
    for nothing in [
        moving(2.9, Some(0.02), 0.006),
        moving(20.0, None, 0.006),
        moving(20.0, Some(f64::NAN), 0.0),
    ] {
        assert_eq!(after(nothing), (0.0, 0.0), "{nothing:?}");
    }
    assert!(after(moving(3.0, Some(0.003), 0.0)).1 > 9e-4);
}

#[test]
fn the_doubt_of_the_heading_grows_by_the_doubt_of_the_curve_that_is_passed() {
    let mut filter = known(POSTS, [0.0; STATES], unsure(&[(0, 0.01), (1, 1e-3), (2, 2e-3)]));
    filter.state.covariance[1][2] = 5e-7;
    filter.state.covariance[2][1] = 5e-7;
    let mut weights = [0.0; STATES];
    (weights[0], weights[1], weights[2]) = (1.0, 2.0, 3.0);
    filter.turn_covariance(&weights);
    let p = &filter.state.covariance;
    assert_near(p[0][1], 2.0 * 1e-6 + 3.0 * 5e-7);
    assert_near(p[0][2], 2.0 * 5e-7 + 3.0 * 4e-6);
    assert_eq!((p[1][0], p[2][0]), (p[0][1], p[0][2]));
    assert_near(p[0][0], 1e-4 + 2.0 * 3.5e-6 + 3.0 * 1.3e-5);
    assert_eq!((p[1][1], p[1][2], p[2][2], p[3][3]), (1e-6, 5e-7, 4e-6, 0.0));
}

#[test]
fn a_circle_fades_as_a_whole() {
    let mut circle = known(YAW_RATE, [0.0; STATES], unsure(&[(1, 1e-3)]));
    circle.fade(5.0, 2.0);
    let p = &circle.state.covariance;
    let faded = square(2.0 * NUMBERS.change_perm) * 5.0 / 25.0;
    assert_near(p[1][1], 1e-6 + faded);
    assert_near(p[2][2], faded);
    assert_near(p[1][8], faded);
    assert_eq!((p[0][0], p[0][1]), (0.0, 0.0));
}

#[test]
fn an_ego_that_stands_keeps_everything_and_one_that_drives_passes_knots() {
    let before = known(POSTS, linear(0.0, 1e-3, 1e-5), unsure(&[(0, 0.01), (3, 1e-3)]));
    for speed_mps in [0.0, -5.0] {
        let mut stands = before;
        stands.advance(0.05, &moving(speed_mps, Some(0.0), 0.0));
        assert_eq!((stands.state, stands.passed_m), (before.state, 0.0));
    }
    let mut drives = before;
    (0..27).for_each(|_| drives.advance(0.05, &moving(20.0, None, 0.0)));
    assert_near(drives.passed_m, 2.0);
    // It follows the road, and the first curvature is that of the second knot.
    assert_near(drives.state.mean[0], 0.0);
    assert_near(drives.state.mean[1], 1.25e-3);
    // Each scan adds to the doubt of the heading.
    let mut once = known(POSTS, [0.0; STATES], unsure(&[(0, 0.01)]));
    once.advance(0.05, &moving(20.0, Some(0.0), 0.0));
    assert_near(once.state.covariance[0][0], 1e-4 + square(NUMBERS.heading_rad));
    // Below 3 m/s the yaw rate does not count: the ego follows the road.
    let turn = |speed_mps: f64| {
        let mut filter = known(POSTS, [0.0; STATES], [0.0; STATES]);
        filter.advance(0.05, &moving(speed_mps, Some(0.1), 0.0));
        filter.state.mean[0]
    };
    assert_eq!(turn(2.9), 0.0);
    assert_near(turn(3.0), -0.1 * 0.05);
}

#[test]
fn an_object_is_compared_with_the_course_that_nearer_ones_have_shown() {
    let mut filter = known(POSTS, [0.0; STATES], unsure(&[(0, 0.01)]));
    filter.edges = filter.edges.with_left(9.0, 100);
    let before = filter.state.mean;
    filter.take_standing(&before, &[(40.0, 9.5), (50.0, 9.0)]);
    let noise = |sigma_m: f64| 0.81 * 25.0 + square(0.0044 * sigma_m);
    // The first one, 0.5 m beyond the edge; the edge moves a fiftieth of it.
    let gain = 1e-4 * 40.0 / (0.16 + noise(40.0));
    let (heading, variance) = (gain * 0.5, 1e-4 * (1.0 - gain * 40.0));
    // The second one, which the turned course has farther to the right.
    let off_m = 9.0 - 50.0 * heading - 9.01;
    let gain = variance * 50.0 / (variance * 2500.0 + noise(50.0));
    assert_near(filter.state.mean[0], heading + gain * off_m);
    assert_near(filter.edges.known()[0].0, 9.01 + 0.02 * off_m);
    assert_eq!(filter.used(), (2, 0));
}

/// The places of a lead that drifts to the left by 0.1 m in 5 m: the last one is 140 m ahead.
#[test]
fn places_of_a_trail_turn_the_course_to_them() {
    let mut filter = known(TRAILS, [0.0; STATES], unsure(&[(0, 0.01)]));
    for scan in 0..16 {
        filter.trails.advance(0.05, 0.0, &moving(20.0, None, 0.0));
        filter.trails.leave(1, (140.0, 0.02 * f64::from(scan)));
    }
    let before = filter.state.mean;
    filter.take_trails(&before);
    assert_eq!(filter.used(), (0, 2));
    // Places at 125, 135 and 140 m, at 0, 0.2 and 0.3 m to the left.
    let noise = |far_m: f64| square(0.35) * 10.0 * (1.0 + square(far_m / 60.0));
    let gain = 1e-4 * 15.0 / (1e-4 * 225.0 + noise(140.0));
    let (heading, variance) = (gain * 0.3, 1e-4 * (1.0 - gain * 15.0));
    let gain = variance * 10.0 / (variance * 100.0 + noise(135.0));
    assert_near(filter.state.mean[0], heading + gain * (0.2 - 10.0 * heading));
}

#[test]
fn a_vehicle_that_changes_lanes_leaves_no_trail() {
    let pairs = |sources: Sources, lateral_mps: f64| {
        let mut filter = known(sources, [0.0; STATES], [0.0; STATES]);
        for scan in 0..20 {
            filter.trails.advance(0.05, 0.0, &moving(20.0, None, 0.0));
            filter.leave_trail(1, (60.0, 2.0), if scan == 18 { lateral_mps } else { 0.0 });
        }
        let mut pairs = Vec::new();
        filter.trails.pairs(|near, far| pairs.push((near, far)));
        pairs
    };
    // A place every 5 m; the newest was left four scans ago.
    assert_eq!(pairs(TRAILS, 0.59)[0], ((41.0, 2.0), (56.0, 2.0)));
    assert_eq!(pairs(TRAILS, -0.59).len(), 2);
    assert!(pairs(TRAILS, 0.61).is_empty() && pairs(TRAILS, -0.61).is_empty());
    assert!(pairs(YAW_RATE, 0.0).is_empty());
}

#[test]
fn the_map_shows_the_curvature_of_each_knot_ahead() {
    let map = Sources { map: true, ..Sources::default() };
    let after = |knot: usize, passed_m: f64, curvatures_perm: &[f64]| {
        let filter = known(map, [0.0; STATES], unsure(&[(1 + knot, 1e-3)]));
        let mut filter = CourseFilter { passed_m, ..filter };
        let ahead = MapAhead { curvatures_perm, first_m: -10.0, cell_m: 20.0 };
        filter.take(&moving(20.0, None, 0.0), Some(&ahead), &[]);
        filter.state.mean[1 + knot]
    };
    let cells = [0.0, 1e-3, 2e-3, 3e-3, 2e-3];
    // The second knot is 25 m ahead, between the middles of the second and the third cell. The third one is in the
    // middle of the fourth.
    assert_near(after(1, 0.0, &cells), 0.5 * 1.75e-3);
    assert_near(after(2, 0.0, &cells), 0.5 * 3e-3);
    // Beyond its last cell the map goes on as it ends.
    assert_near(after(3, 0.0, &cells), 0.5 * 2e-3);
    assert_near(after(6, 0.0, &cells), 0.5 * 2e-3);
    // After 20 m the third one is 30 m ahead. The first one is behind: it has a fifth of the curvature at the ego.
    assert_near(after(2, 20.0, &cells), 0.5 * 2e-3);
    assert_near(after(0, 20.0, &cells), 0.2e-6 / 1.04e-6 * 0.5e-3);
    assert_eq!(after(1, 0.0, &[0.0, 0.1, 0.1]), 0.0, "outside the gate");
    assert_eq!(after(1, 0.0, &[]), 0.0);
}
