//! The lanes of a MAPEM that the vehicle drives on: on its path, in its direction.
//!
//! The vehicle's path is the road, from the scenario's `v2x.origin`: straight, or its way through a net.

use its::geodesy::{Plane, Position};
use its::mapem::{Approach, Connection, IntersectionGeometry, Lane, STRAIGHT};
use road::{Axis, Pose};
use scenario::Scenario;
use scenario::radio::Origin;

use crate::numbers::Numbers;

/// Half of a lane's width if the map has no width, m: that of the simulated road.
const HALF_WIDTH_M: f64 = 1.75;

/// A stop line on the vehicle's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLine {
    pub signal_group: u8,
    pub position_m: f64,
}

/// The plane around the road's beginning, with the road as its axis.
pub fn road_plane(origin: &Origin) -> Plane {
    let (latitude, longitude) = origin.steps();
    Plane::along(Position { latitude, longitude }, origin.heading_deg.value())
}

/// The vehicle's path on the Earth.
#[derive(Clone, Debug)]
pub struct Path {
    pub plane: Plane,
    /// Its way in the plane; a straight line along the plane's axis without one.
    pub axis: Option<Axis>,
}

impl Path {
    pub fn of(scenario: &Scenario) -> Self {
        let net = scenario.traffic.route.as_ref().and(scenario.road.plan());
        Self { plane: road_plane(&scenario.v2x.origin), axis: net.map(|plan| plan.axis().clone()) }
    }

    /// A place on the path in the plane.
    pub fn pose(&self, along_m: f64) -> Pose {
        let straight = Pose { x_m: along_m, ..Pose::default() };
        self.axis.as_ref().map_or(straight, |axis| axis.pose(along_m))
    }

    /// The position on the Earth of a place beside the path, and the path's heading, degrees clockwise from north.
    pub fn earth(&self, along_m: f64, left_m: f64) -> (Position, f64) {
        let pose = self.pose(along_m);
        let (x_m, y_m) = pose.to_world(0.0, left_m);
        let (sine, cosine) = libm::sincos(pose.heading_rad);
        let (east, north) = self.plane.to_earth((cosine, sine));
        (self.plane.position(x_m, y_m), libm::atan2(east, north).to_degrees().rem_euclid(360.0))
    }

    /// Distance of a position along the path and to its left, m.
    pub fn point(&self, position: Position) -> (f64, f64) {
        let (x_m, y_m) = self.plane.point(position);
        self.place(x_m, y_m).0
    }

    /// The same of a point of the plane, with cosine and sine of the path's heading there.
    fn place(&self, x_m: f64, y_m: f64) -> ((f64, f64), (f64, f64)) {
        let Some(axis) = &self.axis else { return ((x_m, y_m), (1.0, 0.0)) };
        let (along_m, left_m) = axis.nearest(x_m, y_m);
        let (sine, cosine) = libm::sincos(axis.heading_rad(along_m));
        ((along_m, left_m), (cosine, sine))
    }
}

/// The stop lines of the way straight on, or of the way of the path, nearest to the origin first.
pub fn stop_lines(
    geometry: &IntersectionGeometry,
    path: &Path,
    numbers: &Numbers,
) -> Vec<StopLine> {
    let reference = path.plane.point(geometry.reference);
    let half_m = geometry.lane_width_cm.map_or(HALF_WIDTH_M, |cm| f64::from(cm) / 200.0);
    let metres = |(east, north): (i16, i16)| {
        path.plane.from_earth((f64::from(east) / 100.0, f64::from(north) / 100.0))
    };
    let placed = |(x_m, y_m): (f64, f64)| path.place(reference.0 + x_m, reference.1 + y_m);
    let leads_on = |connection: &&Connection| {
        let exit = geometry.lanes.iter().find(|other| other.id == connection.lane);
        let exit = exit.and_then(|exit| exit.nodes.first());
        exit.is_some_and(|node| placed(metres(*node)).0.1.abs() <= half_m)
    };
    let line = |lane: &Lane| {
        let Approach::Ingress(_) = lane.approach else { return None };
        let [first, second, ..] = lane.nodes[..] else { return None };
        let ((position_m, left_m), (cosine, sine)) = placed(metres(first));
        let (away_x, away_y) = metres(second);
        let along_m = away_x * cosine + away_y * sine;
        // Nodes lead away from the stop line, the vehicle drives towards it.
        let is_same_way = -along_m > numbers.same_way_cos * libm::hypot(away_x, away_y);
        if !is_same_way || left_m.abs() > half_m {
            return None;
        }
        let is_straight = |connection: &&Connection| {
            connection.maneuver.unwrap_or(lane.maneuvers) & STRAIGHT != 0
        };
        let onward = path.axis.as_ref().and_then(|_| lane.connections.iter().find(leads_on));
        let straight = onward.or_else(|| lane.connections.iter().find(is_straight))?;
        Some(StopLine { signal_group: straight.signal_group?, position_m })
    };
    let mut lines: Vec<StopLine> = geometry.lanes.iter().filter_map(line).collect();
    lines.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
    lines
}
