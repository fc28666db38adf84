//! The curvature and the speed limits ahead, as the controller has them, and the curvature of the ego's own way.

use super::Cap;
use messages::Course;
use scenario::sumo_traffic::Limit;

/// Largest curvature of a road, 1/m: a larger one is an error.
const SHARPEST_PERM: f64 = 1.0 / 15.0;
/// Distance between two looks at a clothoid, m.
const STEP_M: f64 = 5.0;
/// Way on which the curve of the ego's own way goes on, m. Chosen: the way of 1.5 s at 33 m/s.
const OWN_M: f64 = 50.0;
/// A clothoid is looked at so far ahead at most, m.
const FARTHEST_M: f64 = 300.0;

/// Mean curvatures in cells of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells<'a> {
    /// Start of the first cell, m ahead of the ego; negative behind it.
    pub first_m: f64,
    pub cell_m: f64,
    pub curvatures_perm: &'a [f64],
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadAhead<'a> {
    /// Curvature of the ego's own way, 1/m. It counts without a map: a course may be wrong about a tight curve.
    pub own_perm: Option<f64>,
    /// Perception's estimate.
    pub course: Option<&'a Course>,
    pub map: Option<Cells<'a>>,
    /// Speed limits of a route, in the order of their places.
    pub limits: &'a [Limit],
    /// Place of the ego on the route, m.
    pub place_m: f64,
}

impl RoadAhead<'_> {
    /// Calls `see` with the stretches of the road, from and to m ahead, and their curvatures, 1/m. Curvatures that no
    /// road can have are left out.
    pub(super) fn each(&self, mut see: impl FnMut(f64, f64, f64)) {
        let mut sound = |from_m: f64, to_m: f64, curvature_perm: f64| {
            // NaN is not below either.
            if curvature_perm.abs() <= SHARPEST_PERM {
                see(from_m, to_m, curvature_perm);
            }
        };
        if let Some(course) = self.course {
            let valid_m = course.valid_m.clamp(0.0, FARTHEST_M);
            let steps = (valid_m / STEP_M) as u32;
            for step in 0..=steps {
                let ahead_m = f64::from(step) * STEP_M;
                let curvature_perm = course.curvature_perm + course.curvature_rate_perm2 * ahead_m;
                sound(ahead_m, ahead_m + STEP_M, curvature_perm);
            }
        }
        let Some(map) = self.cells() else {
            self.own_perm.iter().for_each(|own_perm| sound(0.0, OWN_M, *own_perm));
            return;
        };
        for (cell, curvature_perm) in map.curvatures_perm.iter().enumerate() {
            // A mean is reached in the cell's middle, or half a cell earlier where the next cell is as sharp.
            let from_m = map.first_m + (cell as f64 - 0.5) * map.cell_m;
            if from_m + 1.5 * map.cell_m > 0.0 {
                sound(from_m.max(0.0), (from_m + map.cell_m).max(0.0), *curvature_perm);
            }
        }
    }

    /// The speed limits from the present one on, in the order of their places.
    pub(super) fn limits(&self) -> impl Iterator<Item = Cap> {
        let next = self.limits.partition_point(|limit| limit.from_m <= self.place_m);
        let ahead = &self.limits[next.saturating_sub(1)..];
        let ends_m = ahead.iter().skip(1).map(|limit| limit.from_m).chain([f64::INFINITY]);
        ahead.iter().zip(ends_m).map(|(limit, end_m)| Cap {
            from_m: (limit.from_m - self.place_m).max(0.0),
            to_m: end_m - self.place_m,
            speed_mps: limit.speed_mps,
        })
    }

    /// The map, if it is one and covers some road ahead.
    fn cells(&self) -> Option<&Cells<'_>> {
        let covers = |map: &&Cells<'_>| {
            let end_m = map.first_m + map.cell_m * map.curvatures_perm.len() as f64;
            map.cell_m >= 1.0 && end_m.is_finite() && end_m > 0.0 && map.first_m <= 0.0
        };
        self.map.as_ref().filter(covers)
    }
}

/// Time constant of the own way's low-pass, s. Chosen: half of the time after which an ended curve holds nothing back.
const LAG_S: f64 = 0.5;
/// A yaw rate within this counts as zero, rad/s. Chosen: three standard deviations of the sensor's offset and noise,
/// 0.14 °/s.
const NONE_RADPS: f64 = 0.0075;
/// Speed below which a yaw rate does not show a curvature, m/s.
const SLOWEST_MPS: f64 = 3.0;

/// The curvature of the ego's own way, as far as its yaw rate surely shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnWay {
    curvature_perm: Option<f64>,
}

impl OwnWay {
    /// Takes a yaw rate at a speed, `period_s` after the last one; returns the curvature, 1/m. Below 3 m/s it stays.
    pub fn take(&mut self, yaw_rate_radps: f64, speed_mps: f64, period_s: f64) -> Option<f64> {
        if speed_mps >= SLOWEST_MPS && yaw_rate_radps.is_finite() {
            let surely_radps = (yaw_rate_radps.abs() - NONE_RADPS).max(0.0);
            let now_perm = surely_radps.copysign(yaw_rate_radps) / speed_mps;
            let before_perm = self.curvature_perm.unwrap_or(now_perm);
            let gain = 1.0 - libm::exp(-period_s / LAG_S);
            self.curvature_perm = Some(before_perm + gain * (now_perm - before_perm));
        }
        self.curvature_perm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn places(road: &RoadAhead<'_>) -> Vec<(f64, f64, f64)> {
        let mut places = Vec::new();
        road.each(|from_m, to_m, curvature_perm| places.push((from_m, to_m, curvature_perm)));
        places
    }

    #[test]
    fn a_map_is_seen_from_the_ego_s_cell_on() {
        let curvatures_perm = [1e-3, 2e-3, 3e-3];
        let map =
            |first_m| Some(Cells { first_m, cell_m: 25.0, curvatures_perm: &curvatures_perm });
        let road = RoadAhead { map: map(-10.0), own_perm: Some(9e-3), ..RoadAhead::default() };
        assert_eq!(places(&road), [(0.0, 2.5, 1e-3), (2.5, 27.5, 2e-3), (27.5, 52.5, 3e-3)]);
        let passed = RoadAhead { map: map(-30.0), ..RoadAhead::default() };
        assert_eq!(places(&passed)[0], (0.0, 7.5, 2e-3));
    }

    #[test]
    fn the_own_way_counts_where_no_map_is_known() {
        let own = RoadAhead { own_perm: Some(-2e-3), ..RoadAhead::default() };
        assert_eq!(places(&own), [(0.0, OWN_M, -2e-3)]);
        let ended = Cells { first_m: -90.0, cell_m: 25.0, curvatures_perm: &[1e-3] };
        assert_eq!(places(&RoadAhead { map: Some(ended), ..own }), [(0.0, OWN_M, -2e-3)]);
        let empty = Cells { curvatures_perm: &[], ..ended };
        assert_eq!(places(&RoadAhead { map: Some(empty), ..own }), [(0.0, OWN_M, -2e-3)]);
        assert_eq!(places(&RoadAhead::default()), []);
    }

    #[test]
    fn a_course_counts_as_far_as_it_holds() {
        let (curvature_perm, curvature_rate_perm2) = (1e-3, 1e-4);
        let course =
            Course { curvature_perm, curvature_rate_perm2, valid_m: 12.0, ..Course::zeroed() };
        let road = RoadAhead { course: Some(&course), ..RoadAhead::default() };
        let [(0.0, 5.0, a), (5.0, 10.0, b), (10.0, 15.0, c)] = places(&road)[..] else {
            panic!("three places")
        };
        assert!((a - 1e-3).abs() < 1e-12 && (b - 1.5e-3).abs() < 1e-12);
        assert!((c - 2e-3).abs() < 1e-12);
    }

    #[test]
    fn impossible_points_of_a_road_are_left_out() {
        let wrong = [f64::NAN, f64::INFINITY, 0.1, -1e-3];
        let map = Cells { first_m: 0.0, cell_m: 25.0, curvatures_perm: &wrong };
        assert_eq!(
            places(&RoadAhead { map: Some(map), ..RoadAhead::default() }),
            [(62.5, 87.5, -1e-3)]
        );
        for map in [Cells { cell_m: f64::NAN, ..map }, Cells { first_m: f64::NAN, ..map }] {
            assert_eq!(places(&RoadAhead { map: Some(map), ..RoadAhead::default() }), []);
        }
        let course = Course { valid_m: f64::NAN, ..Course::zeroed() };
        assert!(places(&RoadAhead { course: Some(&course), ..RoadAhead::default() }).len() < 100);
    }

    #[test]
    fn a_straight_road_is_straight_whatever_the_sensor_says() {
        let mut own = OwnWay::default();
        for yaw_rate_radps in [0.004, -0.007, 0.0, f64::NAN] {
            own.take(yaw_rate_radps, 5.0, 0.1);
        }
        assert_eq!(own.take(0.0, 5.0, 0.1), Some(0.0));
    }

    #[test]
    fn a_curve_shows_after_the_lag_and_stays_when_the_ego_stops() {
        let mut own = OwnWay::default();
        assert_eq!(own.take(0.1, 1.0, 0.1), None);
        own.take(0.0, 20.0, 0.1);
        for _ in 0..50 {
            own.take(-0.08, 20.0, 0.1);
        }
        let curvature_perm = own.take(-9.0, 1.0, 0.1).expect("known");
        assert!((curvature_perm + 0.0725 / 20.0).abs() < 1e-6, "{curvature_perm}");
    }
}
