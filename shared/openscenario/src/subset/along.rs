//! Positions, those on routes and on lines among them.

use road::Pose;

use super::catalog::FromCatalog;
use super::position::{
    LanePosition, Orientation, RelativeLanePosition, RelativeObjectPosition, RelativeRoadPosition,
    RelativeWorldPosition, RoadPosition, WorldPosition, in_plane, oriented,
};
use super::route::Route;
use super::trajectory::TrajectoryRef;
use crate::declare::{AtLeastZero, Number, OneOf, Whole, elements};
use crate::model::position::{self, From, Heading};
use crate::parameter::Scoped;

/// A place on a route: along it, and from the reference line or from the middle of a lane.
pub(crate) struct InRoute {
    path_m: f64,
    lane: Option<i32>,
    aside_m: f64,
}

elements! { "Positions";
    /// of the entity's origin
    Position | TargetPositionMaster | TargetPosition -> position::Position [] {
        position: OneOf<(
            WorldPosition,
            RelativeWorldPosition,
            RelativeObjectPosition,
            RoadPosition,
            RelativeRoadPosition,
            LanePosition,
            RelativeLanePosition,
            RoutePosition,
            TrajectoryPosition,
        )>,
    }

    /// a place along a route, counted from its first waypoint; the orientation counts from the route's direction
    RoutePosition -> position::Position []
    {turn: Option<Orientation>, way: RouteRef, place: InRoutePosition}
    |node| {
        let first = node.scene.on_its_way(&node.place(), way[0], &way)?;
        let last = way[way.len() - 1];
        let (From::Road { row, s_m: from_m, .. }, From::Road { row: of, s_m, t_m }) = (first.from, last.from)
        else {
            let reason = "a route that is seen from an entity has no coordinates of its own";
            return Err(node.refuse(reason, "waypoints on the road"));
        };
        let (scenery, of) = (node.scene.row(row), node.scene.row(of));
        let end = scenery.road.place_of(&of.road, s_m, t_m);
        let (to_m, ..) = end.ok_or_else(|| node.refuse("the row of roads ends before the route", "a shorter route"))?;
        let InRoute { path_m, lane, aside_m } = place;
        let length_m = (to_m - from_m).abs();
        if path_m > length_m {
            let reason = format!("{path_m} m are beyond the route's end");
            return Err(node.refuse(reason, format!("at most {length_m} m")));
        }
        let road = &scenery.road;
        let s_m = from_m + path_m.copysign(to_m - from_m);
        let part = road.part_at(s_m);
        let aside_m = if part.reversed { 0.0 - aside_m } else { aside_m };
        let center_m = match lane.map(|id| road.lane(part.inside(s_m), id)) {
            None => part.shift_m,
            Some(Some(lane)) => lane.center_m,
            Some(None) => {
                return Err(node.refuse("the route has no such lane there", road.lane_names(s_m)));
            }
        };
        let ahead_rad = if to_m < from_m { std::f64::consts::PI } else { 0.0 };
        let from = From::Road { row, s_m, t_m: center_m + aside_m };
        Ok(oriented(from, turn, |h_rad| Heading::Road(h_rad + ahead_rad)))
    }

    /// see `RoutePosition`
    RouteRef -> Vec<position::Position> [] {way: OneOf<(Scoped<Route>, FromCatalog<Route>)>}

    /// see `RoutePosition`
    InRoutePosition -> InRoute [] {place: OneOf<(FromRoadCoordinates, FromLaneCoordinates)>}

    /// along the route, and across the reference line
    FromRoadCoordinates -> InRoute ["pathS" path_m: AtLeastZero as "m", "t" t_m: Number as "m"] {}
    { Ok(InRoute { path_m, lane: None, aside_m: t_m }) }

    /// along the route, and from the middle of a lane, positive to the left of the reference line
    FromLaneCoordinates -> InRoute
    ["pathS" path_m: AtLeastZero as "m", "laneId" lane: Whole,
        "laneOffset" offset_m: Option<Number> as "m"] {}
    { Ok(InRoute { path_m, lane: Some(lane), aside_m: offset_m.unwrap_or(0.0) }) }

    /// a place along a line and to its left; the orientation counts from the line's direction
    TrajectoryPosition -> position::Position
    ["s" s_m: AtLeastZero as "m", "t" t_m: Option<Number> as "m"]
    {turn: Option<Orientation>, corners: TrajectoryRef}
    |node| {
        let places = corners.iter().map(|corner| in_plane(node, &corner.position));
        let places = places.collect::<Result<Vec<_>, _>>()?;
        let mut rest_m = s_m;
        for ((row, near_s_m, a), (.., b)) in places.iter().zip(&places[1..]) {
            let (dx_m, dy_m) = (b.x_m - a.x_m, b.y_m - a.y_m);
            let length_m = libm::hypot(dx_m, dy_m);
            if rest_m <= length_m {
                let line = Pose { heading_rad: libm::atan2(dy_m, dx_m), ..*a };
                let at = line.to_world(rest_m, t_m.unwrap_or(0.0));
                let (s_m, t_m) = node.scene.row(*row).ground.project(at, *near_s_m);
                let ahead = |h_rad| Heading::Plane(line.heading_rad + h_rad);
                return Ok(oriented(From::Road { row: *row, s_m, t_m }, turn, ahead));
            }
            rest_m -= length_m;
        }
        let reason = format!("{s_m} m are beyond the line's end");
        Err(node.wrong("s", reason, format!("at most {}", s_m - rest_m)))
    }
}
