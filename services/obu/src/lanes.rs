//! The lanes of a MAPEM that the vehicle drives on: on its path, in its direction.
//!
//! The vehicle's path is the road: straight, from the scenario's `v2x.origin`.

use its::geodesy::{Plane, Position};
use its::mapem::{Approach, IntersectionGeometry, Lane, STRAIGHT};
use scenario::radio::Origin;

use crate::numbers::Numbers;

/// Half of a lane's width if the map has no width, m: that of the simulated road.
const HALF_WIDTH_M: f64 = 1.75;

/// A stop line on the vehicle's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLine {
    /// Signal group that governs it.
    pub signal_group: u8,
    /// Position on the path, m.
    pub position_m: f64,
}

/// The plane around the road's beginning, with the road as its axis.
pub fn road_plane(origin: &Origin) -> Plane {
    let (latitude, longitude) = origin.steps();
    Plane::along(Position { latitude, longitude }, origin.heading_deg.value())
}

/// The stop lines of the way straight on, nearest to the origin first.
pub fn stop_lines(
    geometry: &IntersectionGeometry,
    plane: &Plane,
    numbers: &Numbers,
) -> Vec<StopLine> {
    let reference = plane.point(geometry.reference);
    let half_m = geometry.lane_width_cm.map_or(HALF_WIDTH_M, |cm| f64::from(cm) / 200.0);
    let lines = geometry
        .lanes
        .iter()
        .filter_map(|lane| stop_line(lane, plane, reference, (half_m, numbers.same_way_cos)));
    let mut lines: Vec<StopLine> = lines.collect();
    lines.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    lines
}

fn stop_line(
    lane: &Lane,
    plane: &Plane,
    reference: (f64, f64),
    (half_m, same_way_cos): (f64, f64),
) -> Option<StopLine> {
    let Approach::Ingress(_) = lane.approach else { return None };
    let metres = |(east, north): (i16, i16)| {
        plane.from_earth((f64::from(east) / 100.0, f64::from(north) / 100.0))
    };
    let [first, second, ..] = lane.nodes[..] else { return None };
    let ((to_line_m, to_left_m), (away_x, away_y)) = (metres(first), metres(second));
    let (along_m, left_m) = (reference.0 + to_line_m, reference.1 + to_left_m);
    // Nodes lead away from the stop line, the vehicle drives towards it.
    if -away_x <= same_way_cos * libm::hypot(away_x, away_y) || left_m.abs() > half_m {
        return None;
    }
    let straight = lane.connections.iter().find(|connection| {
        let maneuvers = connection.maneuver.unwrap_or(lane.maneuvers);
        maneuvers & STRAIGHT != 0
    })?;
    Some(StopLine { signal_group: straight.signal_group?, position_m: along_m })
}
