//! Positions by themselves, or seen from an entity.

use std::rc::Rc;

use road::Pose;

use super::reference::EntityName;
use crate::declare::{AtLeastZero, Node, Number, OneOf, Text, Whole, elements, scalars, words};
use crate::error::ReadError;
use crate::model::position::{self, From, Heading, Offset};
use crate::road::Part;
use crate::scene::{LaneHeadings, Scenery};

scalars! {
    /// A road by its id, as a part of a row.
    RoadId -> (Rc<Scenery>, Part): "a road's id", |given| {
        let (id, scene) = (given.text()?, given.node.scene);
        if let Some(expected) = scene.lacks(&id) {
            return Err(given.raw.wrong(format!("there is no road `{id}`"), expected));
        }
        let scenery = scene.road(Some(&id))?;
        let part = scenery.road.part(&id).unwrap_or(&scenery.road.parts[0]).clone();
        Ok((scenery, part))
    };
}

words! {
    /// Meaning of an orientation; the value is true for one in the plane.
    OrientationType = bool { "relative" false, "absolute" true }
}

/// An orientation as it was read.
pub(crate) enum Turn {
    /// From what the position counts its heading from, rad.
    Relative(f64),
    /// In the plane, rad.
    Plane(Heading),
}

elements! { "Positions";
    /// of a waypoint or of a corner, as `Position`
    Spot = "Position" -> position::Position [] {
        position: OneOf<(
            WorldPosition,
            RelativeWorldPosition,
            RelativeObjectPosition,
            RoadPosition,
            RelativeRoadPosition,
            LanePosition,
            RelativeLanePosition,
        )>,
    }

    /// the point of the road nearest to it, which is the nearest road of the file if no position has named one; a missing h is along the reference line
    WorldPosition -> position::Position
    ["x" x_m: Number as "m", "y" y_m: Number as "m", "h" h_rad: Option<Number> as "rad"] {}
    unused ["z?" "p?" "r?"]
    |node| {
        let (scenery, s_m, t_m) = node.scene.nearest(x_m, y_m)?;
        let Scenery { row, ground, .. } = &*scenery;
        let from_road = |h_rad| h_rad - ground.plane.heading_rad - ground.direction_rad(s_m);
        let heading = Heading::Road(h_rad.map_or(0.0, from_road));
        Ok(position::Position { from: From::Road { row: *row, s_m, t_m }, heading })
    }

    /// along the axes of the plane
    RelativeWorldPosition -> position::Position
    ["entityRef" entity: EntityName, "dx" dx_m: Number as "m", "dy" dy_m: Number as "m"]
    {turn: Option<Orientation>}
    unused ["dz?"]
    |node| {
        let axes = Pose { x_m: 0.0, y_m: 0.0, ..node.scene.road(None)?.ground.plane };
        let (dx_m, dy_m) = axes.to_local(dx_m, dy_m);
        let offset = Offset::Plane { dx_m, dy_m };
        Ok(oriented(From::Entity { entity, offset }, turn, Heading::Entity))
    }

    /// in the other entity's own axes
    RelativeObjectPosition -> position::Position
    ["entityRef" entity: EntityName, "dx" ahead_m: Number as "m", "dy" left_m: Number as "m"]
    {turn: Option<Orientation>}
    unused ["dz?"]
    {
        let offset = Offset::Own { ahead_m, left_m };
        Ok(oriented(From::Entity { entity, offset }, turn, Heading::Entity))
    }

    /// along and across the reference line
    RoadPosition -> position::Position
    ["roadId" road: RoadId, "s" s_m: AtLeastZero as "m", "t" t_m: Number as "m"]
    {turn: Option<Orientation>}
    |node| {
        let (scenery, part) = road;
        on_road(node, &part, s_m)?;
        let (s_m, t_m) = part.place(s_m, t_m);
        let from = From::Road { row: scenery.row, s_m, t_m };
        Ok(oriented(from, turn, |h_rad| Heading::Road(h_rad + part.heading_rad())))
    }

    /// along and across the reference line, from another entity
    RelativeRoadPosition -> position::Position
    ["entityRef" entity: EntityName, "ds" ds_m: Number as "m", "dt" dt_m: Number as "m"]
    {turn: Option<Orientation>}
    {
        let offset = Offset::Road { ds_m, dt_m };
        Ok(oriented(From::Entity { entity, offset }, turn, Heading::Road))
    }

    /// the offset counts from the lane's centre, positive to the left of the reference line
    LanePosition -> position::Position
    ["roadId" road: RoadId, "laneId" lane: Text, "s" s_m: AtLeastZero as "m",
        "offset" offset_m: Option<Number> as "m"]
    {turn: Option<Orientation>}
    |node| {
        let (scenery, part) = road;
        on_road(node, &part, s_m)?;
        let offset_m = offset_m.unwrap_or(0.0) * if part.reversed { -1.0 } else { 1.0 };
        let (s_m, _) = part.place(s_m, 0.0);
        let (row, at_m) = (&scenery.road, part.inside(s_m));
        let Some(found) = lane.trim().parse().ok().and_then(|id| row.lane(at_m, id)) else {
            let reason = format!("road `{}` has no lane `{lane}`", part.id);
            return Err(node.wrong("laneId", reason, row.lane_names(at_m)));
        };
        let from = From::Road { row: scenery.row, s_m, t_m: found.center_m + offset_m };
        let headings = node.scene.headings.get();
        let turned = matches!(turn, Some(Turn::Relative(h_rad)) if libm::cos(h_rad) < -0.9);
        let (counts, other) = match headings {
            LaneHeadings::Road if turned => ("reference line", "traffic"),
            LaneHeadings::Traffic if node.scene.are_headings_guessed.get() => ("lane's traffic", "road"),
            _ => ("", ""),
        };
        if row.direction(&found) < 0.0 && !counts.is_empty() {
            node.scene.notice(format!(
                "{}: the heading in lane {} counts from the {counts}. The standard counts from the reference line, \
                 esmini and CARLA from the lane's traffic: `--lane-headings {other}`",
                node.place(), found.id
            ));
        }
        let ahead_rad = match headings {
            LaneHeadings::Road => part.heading_rad(),
            LaneHeadings::Traffic if row.direction(&found) < 0.0 => std::f64::consts::PI,
            LaneHeadings::Traffic => 0.0,
        };
        Ok(oriented(from, turn, |h_rad| Heading::Road(h_rad + ahead_rad)))
    }

    /// dLane counts lanes to the left of the other entity, without lane 0; ds or dsLane, not both
    RelativeLanePosition -> position::Position
    ["entityRef" entity: EntityName, "dLane" lanes_left: Whole, "ds" ds_m: Option<Number> as "m",
        "dsLane" lane_ds_m: Option<Number> as "m", "offset" offset_m: Option<Number> as "m"]
    {turn: Option<Orientation>}
    |node| {
        if ds_m.is_some() == lane_ds_m.is_some() {
            return Err(node.refuse("`ds` and `dsLane` say the same here", "one of them"));
        }
        let ds_m = ds_m.or(lane_ds_m).unwrap_or(0.0);
        let offset = Offset::Lane { lanes_left, ds_m, offset_m: offset_m.unwrap_or(0.0) };
        Ok(oriented(From::Entity { entity, offset }, turn, Heading::Road))
    }

    /// absolute in the plane; a missing one is along the reference line, in every lane
    Orientation -> Turn
    ["h" h_rad: Option<Number> as "rad", "type" in_plane: Option<OrientationType>] {}
    unused ["p?" "r?"]
    |node| {
        let h_rad = h_rad.unwrap_or(0.0);
        match in_plane {
            Some(true) => {
                let plane = node.scene.road(None)?.ground.plane;
                Ok(Turn::Plane(Heading::Plane(h_rad - plane.heading_rad)))
            }
            _ => Ok(Turn::Relative(h_rad)),
        }
    }
}

pub(super) fn oriented(
    from: From,
    turn: Option<Turn>,
    relative: impl Fn(f64) -> Heading,
) -> position::Position {
    let heading = match turn.unwrap_or(Turn::Relative(0.0)) {
        Turn::Relative(heading_rad) => relative(heading_rad),
        Turn::Plane(heading) => heading,
    };
    position::Position { from, heading }
}

/// Checks that the attribute `s` of a position is on its road.
fn on_road(node: Node<'_>, part: &Part, s_m: f64) -> Result<(), ReadError> {
    if s_m <= part.length_m {
        return Ok(());
    }
    let reason = format!("{s_m} m are beyond the road's end");
    Err(node.wrong("s", reason, format!("at most {}", part.length_m)))
}

/// The row of a position, its place along that, m, and its pose in the plane.
pub(super) fn in_plane(
    node: Node<'_>,
    position: &position::Position,
) -> Result<(usize, f64, Pose), ReadError> {
    let From::Road { row, s_m, t_m } = position.from else {
        let reason = "a line that is seen from an entity has no coordinates of its own";
        return Err(node.refuse(reason, "places on the road"));
    };
    let at = node.scene.row(row).ground.point(s_m, t_m);
    let heading_rad = match position.heading {
        Heading::Plane(heading_rad) => heading_rad,
        Heading::Road(heading_rad) | Heading::Entity(heading_rad) => at.heading_rad + heading_rad,
    };
    Ok((row, s_m, Pose { heading_rad, ..at }))
}
