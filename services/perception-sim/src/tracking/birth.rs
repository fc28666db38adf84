//! New tracks from detections that belong to none.
//!
//! Standing targets: a track begins with a standing echo only in the ego's lane ([`Numbers::standing_half_width_m`]), or
//! where the belief about the road allows it. There a standing object is an obstacle. The track needs twice the scans to
//! be confirmed. Standing echoes elsewhere count as roadside. Nothing begins three lanes off: it cannot come before the
//! ego soon, and most mirror images in a guard rail are there ([`Numbers::farthest_m`]).
//!
//! A detection whose vehicle the radar knows begins a track wherever it is, and counts as a vehicle that has moved.

use super::association::Point;
use super::numbers::Numbers;
use super::sighting::Sighting;

/// An echo moves over ground.
pub fn moves(point: &Point, numbers: &Numbers) -> bool {
    let noise_mps = numbers.surely_sigma * point.range_rate_variance.sqrt();
    point.ground_speed_mps.abs() > numbers.standing_mps + noise_mps
}

/// Calls `begin` with what is seen of each new vehicle, and whether it moves. Nothing that stands and `is_aside` begins
/// a track. The points used belong to nothing else afterwards.
pub fn find(
    points: &mut [Point],
    is_aside: impl Fn(&Point) -> bool,
    numbers: &Numbers,
    mut begin: impl FnMut(&Sighting, bool),
) {
    for point in points.iter_mut() {
        let stands_aside = !moves(point, numbers) && is_aside(point);
        if point.owner.is_none()
            && point.vehicle.is_none()
            && (stands_aside || point.y_m.abs() > numbers.farthest_m)
        {
            point.owner = Some(NO_TRACK);
        }
    }
    for first in 0..points.len() {
        if points[first].owner.is_some() {
            continue;
        }
        let seed = points[first];
        for point in &mut points[first..] {
            if point.owner.is_none()
                && point.vehicle == seed.vehicle
                && together(&seed, point, numbers)
            {
                point.owner = Some(NEW_TRACK);
            }
        }
        let members = points.iter().filter(|point| point.owner == Some(NEW_TRACK));
        if let Some(sighting) = Sighting::of(members, 0.0, numbers) {
            begin(&sighting, seed.vehicle.is_some() || moves(&seed, numbers));
        }
        for point in points.iter_mut().filter(|point| point.owner == Some(NEW_TRACK)) {
            point.owner = Some(NO_TRACK);
        }
    }
}

/// Owner of what belongs to no track and begins none.
const NO_TRACK: usize = usize::MAX;
/// Owner of what belongs to the track that is about to begin.
const NEW_TRACK: usize = usize::MAX - 1;

fn together(a: &Point, b: &Point, numbers: &Numbers) -> bool {
    // Noise alone sets points apart.
    let sigma_m = (a.lateral_variance + b.lateral_variance).sqrt();
    let sigma_mps = (a.range_rate_variance + b.range_rate_variance).sqrt();
    let width_m = numbers.cluster_width_m + numbers.likely_sigma * sigma_m;
    let rate_mps = numbers.cluster_rate_mps + numbers.surely_sigma * sigma_mps;
    (b.x_m - a.x_m).abs() < numbers.cluster_length_m
        && (b.y_m - a.y_m).abs() < width_m
        && (b.relative_speed_mps(0.0) - a.relative_speed_mps(0.0)).abs() < rate_mps
}

#[cfg(test)]
mod tests {
    use super::super::association::tests::point;
    use super::*;

    fn aside(point: &Point) -> bool {
        point.y_m.abs() > Numbers::DEFAULT.standing_half_width_m
    }

    fn begun(points: &[Point]) -> usize {
        let (mut points, mut count) = (points.to_vec(), 0);
        find(&mut points, aside, &Numbers::DEFAULT, |_, _| count += 1);
        assert!(points.iter().all(|point| point.owner.is_some()));
        count
    }

    #[test]
    fn the_echoes_of_a_vehicle_begin_one_track_and_two_vehicles_two() {
        let car = [point(40.0, 0.8, 0.1), point(40.0, -0.8, 0.0), point(44.0, 0.9, -0.1)];
        assert_eq!(begun(&car), 1);
        let beside = point(41.0, 3.5, 0.0);
        assert_eq!(begun(&[car[0], car[1], beside]), 2);
        let faster = point(41.0, 0.0, 6.0);
        assert_eq!(begun(&[car[0], car[1], faster]), 2);
    }

    #[test]
    fn a_standing_echo_begins_a_track_in_the_lane_only() {
        assert_eq!(begun(&[point(60.0, 1.0, -20.0)]), 1);
        assert_eq!(begun(&[point(60.0, 8.0, -20.0), point(60.0, -3.0, -20.0)]), 0);
        assert_eq!(begun(&[point(60.0, 3.5, -12.0)]), 1);
    }

    #[test]
    fn nothing_begins_more_than_three_lanes_off() {
        assert_eq!(begun(&[point(60.0, -10.0, -2.0)]), 1);
        assert_eq!(begun(&[point(60.0, -16.0, -2.0)]), 0);
    }

    const NUMBERS: Numbers = Numbers::DEFAULT;

    /// A point whose range rate has a deviation of 0.1 m/s.
    #[test]
    fn an_echo_moves_from_three_deviations_above_walking_speed_on() {
        for (ground_speed_mps, expected) in
            [(1.29, false), (1.31, true), (-1.29, false), (-1.31, true)]
        {
            let point = Point { ground_speed_mps, ..point(40.0, 0.0, 0.0) };
            assert_eq!(moves(&point, &NUMBERS), expected, "{ground_speed_mps}");
        }
    }

    /// Two lateral deviations of a pair are 2 · 0.2828 m, three of their speeds 3 · 0.1414 m/s.
    #[test]
    fn points_of_one_vehicle_are_near_each_other_and_as_fast() {
        let seed = point(40.0, 0.0, 0.0);
        let (width_m, rate_mps) = (2.0 + 2.0 * f64::sqrt(0.08), 1.0 + 3.0 * f64::sqrt(0.02));
        for (share, expected) in [(0.99, true), (-0.99, true), (1.01, false), (-1.01, false)] {
            let is_one = |point: Point| together(&seed, &point, &NUMBERS);
            assert_eq!(is_one(point(40.0 + 5.0 * share, 0.0, 0.0)), expected, "{share} along");
            assert_eq!(is_one(point(40.0, width_m * share, 0.0)), expected, "{share} across");
            assert_eq!(is_one(point(40.0, 0.0, rate_mps * share)), expected, "{share} faster");
        }
    }

    #[test]
    fn a_new_vehicle_has_all_its_points_and_says_whether_it_moves() {
        let mut points = [point(40.0, 0.5, 0.0), point(42.0, -0.5, 0.0), point(80.0, 0.0, -20.0)];
        points[2].detection = 5;
        let mut seen = Vec::new();
        find(&mut points, aside, &NUMBERS, |sighting, moves| {
            seen.push((sighting.nearest, sighting.farthest_m, moves));
        });
        assert_eq!(seen, [(0, 42.0, true), (5, 80.0, false)]);
    }

    #[test]
    fn a_point_that_a_track_has_taken_begins_nothing() {
        let mut taken = [Point { owner: Some(0), ..point(60.0, 0.0, -5.0) }];
        find(&mut taken, aside, &NUMBERS, |_, _| panic!("it is taken"));
        assert_eq!(taken[0].owner, Some(0));
    }
}
