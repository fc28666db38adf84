//! The course against roads whose curvature changes.

use super::*;
use crate::random::Random;

const DT_S: f64 = 0.05;
const SPEED_MPS: f64 = 25.0;
const ALL: Sources =
    Sources { yaw_rate: true, standing: true, trails: true, map: false, as_belief: false };

/// A road whose curvature rises from 0 to 1/`radius_m` over 80 m from `from_m` on: places by small steps.
struct Road {
    points: Vec<(f64, f64, f64)>,
}

impl Road {
    fn new(radius_m: f64, from_m: f64) -> Self {
        let mut points = vec![(0.0, 0.0, 0.0)];
        for k in 0..12_000 {
            let (x, y, heading) = points[k];
            let s = k as f64 * 0.1;
            let curvature = ((s - from_m) / 80.0).clamp(0.0, 1.0) / radius_m;
            let (sine, cosine) = libm::sincos(heading);
            points.push((x + 0.1 * cosine, y + 0.1 * sine, heading + 0.1 * curvature));
        }
        Self { points }
    }

    fn at(&self, s_m: f64) -> (f64, f64, f64) {
        self.points[((s_m * 10.0).round() as usize).min(self.points.len() - 1)]
    }

    /// A place of the road in the axes of an ego at `ego_m`.
    fn seen(&self, ego_m: f64, s_m: f64, d_m: f64) -> (f64, f64) {
        let (ego, there) = (self.at(ego_m), self.at(s_m));
        let (sine, cosine) = libm::sincos(there.2);
        let (dx, dy) = (there.0 - d_m * sine - ego.0, there.1 + d_m * cosine - ego.1);
        let (sine, cosine) = libm::sincos(ego.2);
        (cosine * dx + sine * dy, cosine * dy - sine * dx)
    }

    fn curvature(&self, s_m: f64) -> f64 {
        (self.at(s_m + 0.5).2 - self.at(s_m - 0.5).2).max(0.0)
    }
}

/// Posts before an ego at `ego_m`, every 20 m on both sides, some 9.5 m from the middle, with noise.
fn posts(road: &Road, ego_m: f64, random: &mut Random) -> Vec<(f64, f64)> {
    let first = (ego_m / 20.0).ceil() as i32;
    let mut seen = Vec::new();
    for cell in first..first + 7 {
        for side in [1.0, -1.0] {
            let d_m = side
                * (8.0 + 3.0 * crate::random::fixed(7, (2 * cell) as u64 + (side > 0.0) as u64));
            let (x, y) = road.seen(ego_m, f64::from(cell) * 20.0, d_m);
            if x > 3.0 && y.abs() < 0.577 * x && random.uniform() < 0.6 {
                let turn = 0.004 * random.normal();
                seen.push((x - y * turn, y + x * turn));
            }
        }
    }
    seen
}

/// Drives into the curve; calls back with the ego's place and the filter.
fn drive(radius_m: f64, sources: Sources, lead: bool, mut each: impl FnMut(f64, &CourseFilter)) {
    let (road, mut random) = (Road::new(radius_m, 400.0), Random::of_run(3, 0));
    let mut filter = CourseFilter::new(sources, &CourseNumbers::DEFAULT);
    for scan in 1..500 {
        let ego_m = 2.0 + f64::from(scan) * SPEED_MPS * DT_S;
        let motion = Motion {
            speed_mps: SPEED_MPS,
            yaw_rate_radps: Some(
                SPEED_MPS * road.curvature(ego_m) + 0.0017 * (1.0 + random.normal()),
            ),
            slip_rad: 0.004 * random.normal(),
        };
        filter.advance(DT_S, &motion);
        filter.take(&motion, None, &posts(&road, ego_m, &mut random));
        if lead {
            let (x, y) = road.seen(ego_m, ego_m + 80.0, 0.0);
            let there = filter.course().locate(x, y);
            filter.leave_trail(1, (there.sigma_m, there.d_m), 0.0);
        }
        each(ego_m, &filter);
    }
}

/// Root mean square of the road's place against the course 80 m ahead, m.
fn error_m(sources: Sources, lead: bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    let road = Road::new(500.0, 400.0);
    drive(500.0, sources, lead, |ego_m, filter| {
        if ego_m > 100.0 {
            let (x, y) = road.seen(ego_m, ego_m + 80.0, 0.0);
            let d_m = filter.course().locate(x, y).d_m;
            (sum, count) = (sum + d_m * d_m, count + 1.0);
        }
    });
    libm::sqrt(sum / count)
}

#[test]
fn each_source_brings_the_course_nearer_to_the_road() {
    let yaw_rate = Sources { yaw_rate: true, ..Sources::default() };
    let standing = Sources { standing: true, ..yaw_rate };
    let straight = error_m(Sources::default(), false);
    let [by_yaw, by_posts, by_all] =
        [error_m(yaw_rate, false), error_m(standing, false), error_m(ALL, true)];
    assert!(straight > 3.0, "{straight}");
    assert!(by_yaw < 1.6, "{by_yaw}");
    assert!(by_posts < 0.6 * by_yaw, "{by_posts} of {by_yaw}");
    assert!(by_all < 0.6, "{by_all}");
}

#[test]
fn the_error_is_as_large_as_it_says() {
    let road = Road::new(500.0, 400.0);
    let (mut within, mut count) = (0.0, 0.0);
    drive(500.0, ALL, true, |ego_m, filter| {
        if ego_m > 100.0 {
            let (x, y) = road.seen(ego_m, ego_m + 80.0, 0.0);
            let d_m = filter.course().locate(x, y).d_m;
            within += f64::from(u8::from(d_m.abs() < 2.0 * filter.sigma_m(80.0)));
            count += 1.0;
        }
    });
    assert!(within / count > 0.8, "{}", within / count);
}

#[test]
fn a_queue_in_the_next_lane_does_not_bend_it() {
    let (road, mut random) = (Road::new(1e9, 1e9), Random::of_run(5, 0));
    let mut filter = CourseFilter::new(ALL, &CourseNumbers::DEFAULT);
    for scan in 1..300 {
        let ego_m = f64::from(scan) * SPEED_MPS * DT_S;
        let motion = Motion { speed_mps: SPEED_MPS, yaw_rate_radps: Some(0.0), slip_rad: 0.0 };
        let mut standing = posts(&road, ego_m, &mut random);
        if scan > 100 {
            standing.extend((1..12).map(|k| (10.0 * f64::from(k), 3.5)));
        }
        standing.sort_by(|a, b| a.0.total_cmp(&b.0));
        filter.advance(DT_S, &motion);
        filter.take(&motion, None, &standing);
        if scan > 60 {
            let d_m = filter.course().locate(80.0, 0.0).d_m;
            assert!(d_m.abs() < 1.0, "{d_m} at scan {scan}");
        }
    }
}

#[test]
fn the_map_shows_a_curve_before_it_is_reached() {
    let mut filter = CourseFilter::new(
        Sources { yaw_rate: true, map: true, ..Sources::default() },
        &CourseNumbers::DEFAULT,
    );
    let motion = Motion { speed_mps: 20.0, yaw_rate_radps: Some(0.0), slip_rad: 0.0 };
    let curvatures = [0.0, 0.0, 0.0, 0.002, 0.002, 0.002, 0.002, 0.002];
    let map = MapAhead { curvatures_perm: &curvatures, first_m: 0.0, cell_m: 25.0 };
    for _ in 0..20 {
        filter.advance(0.0, &motion);
        filter.take(&motion, Some(&map), &[]);
    }
    // The road is 1.3 m to the left at 100 m by the map's own integral.
    let d_m = filter.course().locate(100.0, 1.3).d_m;
    assert!(d_m.abs() < 0.6, "{d_m}");
    let none = MapAhead { curvatures_perm: &[], ..map };
    filter.take(&motion, Some(&none), &[]);
}

#[test]
fn without_a_source_it_stays_straight_and_standing_keeps_it() {
    let mut filter = CourseFilter::new(Sources::default(), &CourseNumbers::DEFAULT);
    let turning = Motion { speed_mps: 20.0, yaw_rate_radps: Some(0.2), slip_rad: 0.0 };
    filter.advance(DT_S, &turning);
    filter.take(&turning, None, &[(30.0, 9.0)]);
    assert!(filter.course().is_straight() && filter.sigma_m(100.0) == 0.0);

    let mut kept = None;
    drive(400.0, ALL, true, |_, filter| kept = Some(*filter));
    let mut filter = kept.expect("it drove");
    let before = filter.clothoid();
    for _ in 0..1000 {
        let standing = Motion { yaw_rate_radps: Some(0.0017), ..Motion::default() };
        filter.advance(DT_S, &standing);
        filter.take(&standing, None, &[]);
    }
    let after = filter.clothoid();
    assert!((before[1] - after[1]).abs() < 1e-5 && (before[0] - after[0]).abs() < 1e-3);
}
