//! Positions.

use std::rc::Rc;

use super::reference::EntityName;
use crate::declare::{
    AtLeastZero, Given, Node, Number, OneOf, Scalar, Text, Whole, elements, words,
};
use crate::error::ReadError;
use crate::model::position::{self, From, Heading};
use crate::road::{Line, Road};

/// A road by its id: the same one for all positions.
struct RoadId;

impl Scalar for RoadId {
    type Value = Rc<Road>;

    fn kind() -> String {
        "a road's id".to_owned()
    }

    fn take(given: &Given<'_>) -> Result<Rc<Road>, ReadError> {
        let (id, scene) = (given.text()?, given.node.scene);
        let road = scene.road(Some(&id))?;
        if scene.assumes_a_road() || road.id == id {
            return Ok(road);
        }
        Err(given.wrong(
            format!("`{id}` is a second road"),
            format!("`{}`, since all that happens is on one road", road.id),
        ))
    }
}

words! {
    /// How an orientation is meant; its value is whether in the plane.
    OrientationType = bool { "relative" false, "absolute" true }
}

/// An orientation as it was read.
pub(crate) enum Turn {
    /// From what the position counts its heading from, rad.
    Relative(f64),
    /// From the road's reference line, rad.
    Road(f64),
}

elements! { "Positions";
    /// of the entity's origin
    Position -> position::Position [] {
        position: OneOf<(
            WorldPosition,
            RelativeWorldPosition,
            RelativeObjectPosition,
            RoadPosition,
            RelativeRoadPosition,
            LanePosition,
            RelativeLanePosition,
        )>,
    } { Ok(position) }

    /// straight roads only
    WorldPosition -> position::Position
    ["x" x_m: Number as "m", "y" y_m: Number as "m", "h" h_rad: Option<Number> as "rad"] {}
    unused ["z?" "p?" "r?"]
    |node| {
        let line = straight(node)?;
        let (s_m, t_m) = line.turned(x_m - line.x_m, y_m - line.y_m);
        let heading = Heading::Road(h_rad.unwrap_or(line.heading_rad) - line.heading_rad);
        Ok(position::Position { from: From::Road { s_m, t_m }, heading })
    }

    /// straight roads only
    RelativeWorldPosition -> position::Position
    ["entityRef" entity: EntityName, "dx" dx_m: Number as "m", "dy" dy_m: Number as "m"]
    {turn: Option<Orientation>}
    unused ["dz?"]
    |node| {
        let (ds_m, dt_m) = straight(node)?.turned(dx_m, dy_m);
        Ok(oriented(From::EntityOnRoad { entity, ds_m, dt_m }, turn, Heading::Entity))
    }

    /// in the other entity's own axes
    RelativeObjectPosition -> position::Position
    ["entityRef" entity: EntityName, "dx" ahead_m: Number as "m", "dy" left_m: Number as "m"]
    {turn: Option<Orientation>}
    unused ["dz?"]
    { Ok(oriented(From::Entity { entity, ahead_m, left_m }, turn, Heading::Entity)) }

    /// along and across the reference line
    RoadPosition -> position::Position
    ["roadId" road: RoadId, "s" s_m: AtLeastZero as "m", "t" t_m: Number as "m"]
    {turn: Option<Orientation>}
    |node| {
        let s_m = on_road(node, &road, s_m)?;
        Ok(oriented(From::Road { s_m, t_m }, turn, Heading::Road))
    }

    /// along and across the reference line, from another entity
    RelativeRoadPosition -> position::Position
    ["entityRef" entity: EntityName, "ds" ds_m: Number as "m", "dt" dt_m: Number as "m"]
    {turn: Option<Orientation>}
    { Ok(oriented(From::EntityOnRoad { entity, ds_m, dt_m }, turn, Heading::Road)) }

    /// the offset counts from the lane's centre, positive to the left of the reference line
    LanePosition -> position::Position
    ["roadId" road: RoadId, "laneId" lane: Text, "s" s_m: AtLeastZero as "m",
        "offset" offset_m: Option<Number> as "m"]
    {turn: Option<Orientation>}
    |node| {
        let Some(found) = lane.trim().parse().ok().and_then(|id| road.lane(id)) else {
            let reason = format!("road `{}` has no lane `{lane}`", road.id);
            return Err(node.wrong("laneId", reason, road.lane_names()));
        };
        let t_m = found.center_m + offset_m.unwrap_or(0.0);
        let s_m = on_road(node, &road, s_m)?;
        Ok(oriented(From::Road { s_m, t_m }, turn, Heading::Road))
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
        let offset_m = offset_m.unwrap_or(0.0);
        Ok(oriented(From::EntityLane { entity, lanes_left, ds_m, offset_m }, turn, Heading::Road))
    }

    /// absolute only on straight roads; a missing one is along the reference line, in every lane
    Orientation -> Turn
    ["h" h_rad: Option<Number> as "rad", "type" in_plane: Option<OrientationType>] {}
    unused ["p?" "r?"]
    |node| {
        let h_rad = h_rad.unwrap_or(0.0);
        match in_plane {
            Some(true) => Ok(Turn::Road(h_rad - straight(node)?.heading_rad)),
            _ => Ok(Turn::Relative(h_rad)),
        }
    }
}

fn oriented(from: From, turn: Option<Turn>, relative: fn(f64) -> Heading) -> position::Position {
    let heading = match turn.unwrap_or(Turn::Relative(0.0)) {
        Turn::Relative(heading_rad) => relative(heading_rad),
        Turn::Road(heading_rad) => Heading::Road(heading_rad),
    };
    position::Position { from, heading }
}

/// The straight reference line that coordinates of the plane need.
fn straight(node: Node<'_>) -> Result<Line, ReadError> {
    node.scene.road(None)?.straight.ok_or_else(|| {
        node.refuse(
            format!("`{}` needs coordinates of the plane, and the road is curved", node.name()),
            "a straight road, or a lane or road position",
        )
    })
}

/// Checks the attribute `s`: the road ends at its length.
fn on_road(node: Node<'_>, road: &Road, s_m: f64) -> Result<f64, ReadError> {
    match road.length_m {
        Some(length_m) if s_m > length_m => {
            let reason = format!("{s_m} m are beyond the road's end");
            Err(node.wrong("s", reason, format!("at most {length_m}")))
        }
        _ => Ok(s_m),
    }
}
