//! New tracks from detections that belong to none.
//!
//! Standing targets: a track begins with a standing echo only in the ego's lane
//! ([`STANDING_HALF_WIDTH_M`]), where a standing object is an obstacle, and needs twice the scans to be
//! confirmed. What stands elsewhere is taken for the roadside. A vehicle that has been tracked while it
//! moved stays a track when it stops. Nothing begins beyond the road's edge ([`super::road_edge`]) nor
//! three lanes off ([`super::mirror`]).

use super::association::{Outline, Point};
use super::mirror;
use super::road_edge::RoadEdge;
use super::track::Sighting;

/// What moves slower than this over ground stands, m/s.
const STANDING_MPS: f64 = 1.0;
/// A standing echo farther from the centre of the lane begins no track, m.
const STANDING_HALF_WIDTH_M: f64 = 2.0;
/// Echoes of one new vehicle are at most this far apart, m and m/s.
const CLUSTER_LENGTH_M: f64 = 5.0;
/// The places that reflect on the side of a long vehicle are at most this far apart along it, and this
/// near to its line, m.
const CHAIN_LENGTH_M: f64 = 8.0;
const CHAIN_WIDTH_M: f64 = 0.5;
const CLUSTER_WIDTH_M: f64 = 2.0;
const CLUSTER_RATE_MPS: f64 = 1.0;

/// An echo moves over ground.
#[must_use]
pub fn moves(point: &Point) -> bool {
    point.ground_speed_mps.abs() > STANDING_MPS + 3.0 * point.range_rate_variance.sqrt()
}

/// Calls `begin` with what is seen of each new vehicle, and whether it moves. `outlines` are those of the
/// tracks that were seen in this scan. The points used belong to nothing else afterwards.
pub fn find(
    points: &mut [Point],
    outlines: &[Outline],
    edge: &RoadEdge,
    mut begin: impl FnMut(&Sighting, bool),
) {
    for point in points.iter_mut() {
        let stands_aside = !moves(point) && point.y_m.abs() > STANDING_HALF_WIDTH_M;
        if point.owner.is_none()
            && (stands_aside
                || mirror::is_too_far(point)
                || edge.is_beyond(point.y_m)
                || outlines.iter().any(|outline| outline.covers(point)))
        {
            point.owner = Some(NO_TRACK);
        }
    }
    for first in 0..points.len() {
        if points[first].owner.is_some() {
            continue;
        }
        let seed = points[first];
        let mut last = seed;
        for point in &mut points[first..] {
            if point.owner.is_none() && (together(&seed, point) || chained(&last, point)) {
                point.owner = Some(NEW_TRACK);
                last = *point;
            }
        }
        let members = points.iter().filter(|point| point.owner == Some(NEW_TRACK));
        if let Some(sighting) = Sighting::of(members, 0.0) {
            begin(&sighting, moves(&seed));
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

fn together(a: &Point, b: &Point) -> bool {
    let width = CLUSTER_WIDTH_M + 2.0 * (a.lateral_variance + b.lateral_variance).sqrt();
    let rate = CLUSTER_RATE_MPS + 3.0 * (a.range_rate_variance + b.range_rate_variance).sqrt();
    (b.x_m - a.x_m).abs() < CLUSTER_LENGTH_M
        && (b.y_m - a.y_m).abs() < width
        && (b.relative_speed_mps(0.0) - a.relative_speed_mps(0.0)).abs() < rate
}

/// Two echoes come from the side of one long vehicle on another lane.
fn chained(a: &Point, b: &Point) -> bool {
    let width = CHAIN_WIDTH_M + 2.0 * (a.lateral_variance + b.lateral_variance).sqrt();
    let rate =
        0.5 * CLUSTER_RATE_MPS + 3.0 * (a.range_rate_variance + b.range_rate_variance).sqrt();
    a.y_m.abs() > STANDING_HALF_WIDTH_M
        && (b.x_m - a.x_m).abs() < CHAIN_LENGTH_M
        && (b.y_m - a.y_m).abs() < width
        && (b.relative_speed_mps(0.0) - a.relative_speed_mps(0.0)).abs() < rate
}

#[cfg(test)]
mod tests {
    use super::super::association::tests::point;
    use super::*;

    fn begun(points: &[Point], edge: &RoadEdge) -> usize {
        let (mut points, mut count) = (points.to_vec(), 0);
        find(&mut points, &[], edge, |_, _| count += 1);
        assert!(points.iter().all(|point| point.owner.is_some()));
        count
    }

    #[test]
    fn the_echoes_of_a_vehicle_begin_one_track_and_two_vehicles_two() {
        let edge = RoadEdge::default();
        let car = [point(40.0, 0.8, 0.1), point(40.0, -0.8, 0.0), point(44.0, 0.9, -0.1)];
        assert_eq!(begun(&car, &edge), 1);
        let beside = point(41.0, 3.5, 0.0);
        assert_eq!(begun(&[car[0], car[1], beside], &edge), 2);
        let faster = point(41.0, 0.0, 6.0);
        assert_eq!(begun(&[car[0], car[1], faster], &edge), 2);
    }

    #[test]
    fn what_stands_begins_a_track_in_the_lane_only() {
        let edge = RoadEdge::default();
        assert_eq!(begun(&[point(60.0, 1.0, -20.0)], &edge), 1);
        assert_eq!(begun(&[point(60.0, 8.0, -20.0), point(60.0, -3.0, -20.0)], &edge), 0);
        assert_eq!(begun(&[point(60.0, 3.5, -12.0)], &edge), 1);
    }

    #[test]
    fn nothing_begins_beyond_the_edge() {
        let mut edge = RoadEdge::default();
        edge.observe(8.0);
        assert_eq!(begun(&[point(60.0, 10.0, -2.0)], &edge), 0);
        assert_eq!(begun(&[point(60.0, -10.0, -2.0)], &edge), 1);
        assert_eq!(begun(&[point(60.0, -16.0, -2.0)], &edge), 0, "more than three lanes off");
    }
}
