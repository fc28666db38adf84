//! Actions across the road.

use super::longitudinal::LaneChangeActionDynamics;
use super::reference::EntityName;
use crate::declare::{Bound, Number, OneOf, Truth, Whole, elements};
use crate::model::action::{Action, LaneTarget, OffsetTarget, Shape};

elements! { "Actions";
    /// replaces the lateral action that is running
    LateralAction -> Action [] {action: OneOf<(LaneChangeAction, LaneOffsetAction)>}

    /// lateral position follows the shape to the lane's centre
    LaneChangeAction -> Action ["targetLaneOffset" offset_m: Option<Number> as "m"]
    {transition: LaneChangeActionDynamics, target: LaneChangeTarget}
    { Ok(Action::LaneChange { target, offset_m: offset_m.unwrap_or(0.0), transition }) }

    /// the lane at the end
    LaneChangeTarget -> LaneTarget [] {target: OneOf<(AbsoluteTargetLane, RelativeTargetLane)>}

    /// a lane's id
    AbsoluteTargetLane -> LaneTarget ["value" id: Whole] {}
    |node| {
        let scenery = node.scene.road(None)?;
        let (road, lanes) = (&scenery.road, &scenery.road.lanes);
        let is_there = lanes.sections.iter().any(|s| s.lanes.iter().any(|lane| lane.id == id));
        if !is_there {
            let reason = format!("road {} has no lane `{id}`", road.names());
            return Err(node.wrong("value", reason, road.lane_names(0.0)));
        }
        Ok(LaneTarget::Lane(id))
    }

    /// lanes to the left of the other entity's lane
    RelativeTargetLane -> LaneTarget ["entityRef" entity: EntityName, "value" lanes_left: Whole] {}
    { Ok(LaneTarget::Beside { entity, lanes_left }) }

    /// lateral position follows the shape to the offset
    LaneOffsetAction -> Action ["continuous" continuous: Truth]
    {dynamics: LaneOffsetActionDynamics, target: LaneOffsetTarget}
    {
        let (shape, max_lateral_mps2) = dynamics;
        Ok(Action::LaneOffset { target, shape, max_lateral_mps2, continuous })
    }

    /// the time follows from the largest lateral acceleration; without it, at once; not with shape linear
    LaneOffsetActionDynamics -> (Shape, Option<f64>)
    ["dynamicsShape" shape: Shape, "maxLateralAcc" most: Option<Bound> as "m/s²"] {}
    |node| {
        let most = most.filter(|most| most.is_finite());
        if shape == Shape::Linear && most.is_some() {
            return Err(node.refuse(
                "a linear offset has no bounded lateral acceleration",
                "shape cubic, sinusoidal or step, or no `maxLateralAcc`",
            ));
        }
        Ok((shape, most))
    }

    /// the offset at the end
    LaneOffsetTarget -> OffsetTarget []
    {target: OneOf<(AbsoluteTargetLaneOffset, RelativeTargetLaneOffset)>}

    /// from the centre of the entity's present lane, positive to the left of the reference line
    AbsoluteTargetLaneOffset -> OffsetTarget ["value" offset_m: Number as "m"] {}
    { Ok(OffsetTarget::Lane(offset_m)) }

    /// from the other entity's lateral position
    RelativeTargetLaneOffset -> OffsetTarget
    ["entityRef" entity: EntityName, "value" offset_m: Number as "m"] {}
    { Ok(OffsetTarget::Entity { entity, offset_m }) }
}
