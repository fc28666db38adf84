//! Positions.

use super::Reader;
use crate::error::{ReadError, one_of};
use crate::model::position::{From, Heading, Position};
use crate::node::Node;
use crate::road::{Line, Road};

impl Reader<'_> {
    /// The position inside an element that holds one `Position`.
    pub(super) fn position_in(&self, parent: Node<'_>) -> Result<Position, ReadError> {
        self.position(parent.child("Position")?)
    }

    fn position(&self, node: Node<'_>) -> Result<Position, ReadError> {
        let kind = node.children().next().expect("the subset demands one");
        match kind.name() {
            "LanePosition" => {
                let road = self.road_of(kind)?;
                let center_m = lane_center(kind, road)?;
                let t_m = center_m + kind.number_or("offset", 0.0)?;
                let s_m = along(kind, road, "s")?;
                self.oriented(kind, From::Road { s_m, t_m }, Heading::Road)
            }
            "RoadPosition" => {
                let road = self.road_of(kind)?;
                let (s_m, t_m) = (along(kind, road, "s")?, kind.number("t")?);
                self.oriented(kind, From::Road { s_m, t_m }, Heading::Road)
            }
            "WorldPosition" => {
                let line = self.straight(kind)?;
                let (dx, dy) = (kind.number("x")? - line.x_m, kind.number("y")? - line.y_m);
                let (sin, cos) = (libm::sin(line.heading_rad), libm::cos(line.heading_rad));
                let from = From::Road { s_m: cos * dx + sin * dy, t_m: cos * dy - sin * dx };
                let heading = kind.number_or("h", line.heading_rad)? - line.heading_rad;
                Ok(Position { from, heading: Heading::Road(heading) })
            }
            "RelativeLanePosition" => {
                if kind.element.attribute("ds").is_some()
                    == kind.element.attribute("dsLane").is_some()
                {
                    return Err(kind.refuse("`ds` and `dsLane` say the same here", "one of them"));
                }
                let ds_m = kind.number_or("ds", 0.0)? + kind.number_or("dsLane", 0.0)?;
                let from = From::EntityLane {
                    entity: self.entity_ref(kind)?,
                    lanes_left: kind.integer("dLane")?,
                    ds_m,
                    offset_m: kind.number_or("offset", 0.0)?,
                };
                self.oriented(kind, from, Heading::Road)
            }
            "RelativeRoadPosition" => {
                let (ds_m, dt_m) = (kind.number("ds")?, kind.number("dt")?);
                let from = From::EntityOnRoad { entity: self.entity_ref(kind)?, ds_m, dt_m };
                self.oriented(kind, from, Heading::Road)
            }
            "RelativeObjectPosition" => {
                let (ahead_m, left_m) = (kind.number("dx")?, kind.number("dy")?);
                let from = From::Entity { entity: self.entity_ref(kind)?, ahead_m, left_m };
                self.oriented(kind, from, Heading::Entity)
            }
            _ => {
                let line = self.straight(kind)?;
                let (dx, dy) = (kind.number("dx")?, kind.number("dy")?);
                let (sin, cos) = (libm::sin(line.heading_rad), libm::cos(line.heading_rad));
                let from = From::EntityOnRoad {
                    entity: self.entity_ref(kind)?,
                    ds_m: cos * dx + sin * dy,
                    dt_m: cos * dy - sin * dx,
                };
                self.oriented(kind, from, Heading::Entity)
            }
        }
    }

    fn oriented(
        &self,
        node: Node<'_>,
        from: From,
        relative: fn(f64) -> Heading,
    ) -> Result<Position, ReadError> {
        let Some(orientation) = node.child_if("Orientation") else {
            return Ok(Position { from, heading: relative(0.0) });
        };
        let heading_rad = orientation.number_or("h", 0.0)?;
        let words = [("relative", false), ("absolute", true)];
        let heading = match orientation.word_if("type", &words)? {
            Some(true) => Heading::Road(heading_rad - self.straight(orientation)?.heading_rad),
            _ => relative(heading_rad),
        };
        Ok(Position { from, heading })
    }

    /// The straight reference line that coordinates of the plane need.
    fn straight(&self, node: Node<'_>) -> Result<Line, ReadError> {
        self.any_road()?.straight.ok_or_else(|| {
            node.refuse(
                format!("`{}` needs coordinates of the plane, and the road is curved", node.name()),
                "a straight road, or a lane or road position",
            )
        })
    }
}

fn lane_center(node: Node<'_>, road: &Road) -> Result<f64, ReadError> {
    let text = node.text("laneId")?;
    let lane = text.trim().parse().ok().and_then(|id| road.lane(id));
    lane.map(|lane| lane.center_m).ok_or_else(|| {
        let known: Vec<String> = road.lanes.iter().map(|lane| lane.id.to_string()).collect();
        node.fault("laneId").error(
            format!("road `{}` has no lane `{text}`", road.id),
            one_of(known.iter().map(String::as_str)),
        )
    })
}

fn along(node: Node<'_>, road: &Road, attribute: &'static str) -> Result<f64, ReadError> {
    let s_m = node.magnitude(attribute)?;
    match road.length_m {
        Some(length_m) if s_m > length_m => Err(node
            .fault(attribute)
            .error(format!("{s_m} m are beyond the road's end"), format!("at most {length_m}"))),
        _ => Ok(s_m),
    }
}
