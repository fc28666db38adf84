//! The vehicle's lanes of a MAPEM: those that lead its way, on its path.
//!
//! The vehicle's path is the simulated road: it begins at [`ROAD_ORIGIN`] and leads to the east.

use its::geodesy::{Plane, Position};
use its::mapem::{Approach, IntersectionGeometry, Lane, STRAIGHT};
use scenario::radio::ROAD_ORIGIN;

/// Half of a lane's width where the map has none, m.
const HALF_WIDTH_M: f64 = 1.75;
/// A lane leads the vehicle's way if its direction is within this of the vehicle's, as a cosine: 30 degrees.
const SAME_WAY: f64 = 0.866;

/// A stop line on the vehicle's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLine {
    /// The signal group that governs it.
    pub signal_group: u8,
    /// Where it is on the path, m.
    pub position_m: f64,
}

/// The plane around the road's beginning.
#[must_use]
pub fn road_plane() -> Plane {
    Plane::at(Position { latitude: ROAD_ORIGIN.0, longitude: ROAD_ORIGIN.1 })
}

/// The stop lines on the vehicle's path, for the way straight on, nearest to the origin first.
#[must_use]
pub fn stop_lines(geometry: &IntersectionGeometry, plane: &Plane) -> Vec<StopLine> {
    let reference = plane.point(geometry.reference);
    let half_m = geometry.lane_width_cm.map_or(HALF_WIDTH_M, |cm| f64::from(cm) / 200.0);
    let lines = geometry.lanes.iter().filter_map(|lane| stop_line(lane, reference, half_m));
    let mut lines: Vec<StopLine> = lines.collect();
    lines.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    lines
}

fn stop_line(lane: &Lane, reference: (f64, f64), half_m: f64) -> Option<StopLine> {
    let Approach::Ingress(_) = lane.approach else { return None };
    let metres = |cm: i16| f64::from(cm) / 100.0;
    let [(first_x, first_y), (along_x, along_y), ..] = lane.nodes[..] else { return None };
    let (east_m, north_m) = (reference.0 + metres(first_x), reference.1 + metres(first_y));
    // Nodes lead away from the stop line, the vehicle towards it.
    let (x, y) = (-metres(along_x), -metres(along_y));
    if x <= SAME_WAY * libm::hypot(x, y) || north_m.abs() > half_m {
        return None;
    }
    let straight = lane.connections.iter().find(|connection| {
        let maneuvers = connection.maneuver.unwrap_or(lane.maneuvers);
        maneuvers & STRAIGHT != 0
    })?;
    Some(StopLine { signal_group: straight.signal_group?, position_m: east_m })
}
