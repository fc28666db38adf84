//! Actions along and across the road: speeds and their profiles, distances, lanes, arrivals at the same time.

use super::along::{TargetPosition, TargetPositionMaster};
use super::reference::EntityName;
use super::trajectory::FollowingMode;
use crate::declare::{
    AtLeastOne, AtLeastZero, Bound, Node, Number, OneOf, Placed, Truth, Whole, elements, scalars,
    words,
};
use crate::error::ReadError;
use crate::model::action::{
    Action, Aside, Dimension, Distance, Gap, LaneTarget, LateralSide, OffsetTarget, Shape, Side,
    Transition,
};
use crate::model::timed::{self, Bounds, Meeting, SpeedEntry, SpeedProfile, SpeedTarget, Steady};

words! {
    /// Meaning of a relative speed; the value is true for a factor.
    SpeedTargetValueType = bool { "delta" false, "factor" true }

    /// Coordinates that do the same along a road.
    CoordinateSystem = () { "entity" (), "lane" (), "road" () }

    /// How exactly a profile is followed; the value is true where bounds come before times.
    ProfileFollowingMode = bool { "follow" true, "position" false }
}

elements! { "Actions";
    /// replaces the longitudinal action that is running
    LongitudinalAction -> Action []
    {action: OneOf<(SpeedAction, LongitudinalDistanceAction, SpeedProfileAction)>}

    /// speed follows the shape to its target
    SpeedAction -> Action [] {transition: SpeedActionDynamics, target: SpeedActionTarget}
    |node| {
        let is_endless = transition.shape == Shape::Step || transition.dimension == Dimension::Rate;
        if target.is_continuous() && !is_endless {
            return Err(node.refuse(
                "a continuous target has no time or distance at which it is reached",
                "shape step or dimension rate",
            ));
        }
        Ok(Action::Speed { target, transition })
    }

    /// see "Shapes"
    SpeedActionDynamics | LaneChangeActionDynamics -> Transition
    ["dynamicsShape" shape: Shape, "dynamicsDimension" dimension: Dimension, "value" value: Number,
        "followingMode" _: Option<FollowingMode>] {}
    |node| {
        if value < 0.0 && dimension != Dimension::Rate {
            return Err(node.wrong("value", format!("{value} is negative"), "0 or more"));
        }
        Ok(Transition { shape, dimension, value: value.abs() })
    }

    /// the speed at the end
    SpeedActionTarget -> SpeedTarget []
    {target: OneOf<(AbsoluteTargetSpeed, RelativeTargetSpeed)>}

    /// a speed
    AbsoluteTargetSpeed -> SpeedTarget ["value" mps: AtLeastZero as "m/s"] {}
    { Ok(SpeedTarget::Absolute(mps)) }

    /// delta (m/s) or factor of the other's speed at the start; continuous: kept up without end
    RelativeTargetSpeed -> SpeedTarget
    ["entityRef" entity: EntityName, "value" value: Number,
        "speedTargetValueType" is_factor: SpeedTargetValueType, "continuous" continuous: Truth] {}
    |node| {
        relative(node, (entity, is_factor, value), continuous)
    }

    /// without constraints the distance is there at once; a time gap counts with the speed of the one behind; distance or timeGap, not both
    LongitudinalDistanceAction -> Action
    ["entityRef" entity: EntityName, "freespace" freespace: Truth, "continuous" continuous: Truth,
        "distance" distance: Option<AtLeastZero> as "m", "timeGap" time: Option<AtLeastZero> as "s",
        "displacement" side: Option<Side>, "coordinateSystem" _: Option<CoordinateSystem>]
    {bounds: Option<DynamicConstraints>}
    |node| {
        let gap = match (distance, time) {
            (Some(gap_m), None) => Gap::Distance(gap_m),
            (None, Some(gap_s)) => Gap::Time(gap_s),
            _ => {
                let reason = "`LongitudinalDistanceAction` has both or none of its two measures";
                return Err(node.refuse(reason, "either `distance` or `timeGap`"));
            }
        };
        let side = side.unwrap_or(Side::Behind);
        // A distance needs both accelerations.
        let limits = bounds.filter(|bounds| {
            bounds.acceleration_mps2.is_finite() && bounds.deceleration_mps2.is_finite()
        });
        Ok(Action::Distance(Distance { entity, gap, freespace, side, continuous, limits }))
    }

    /// position: straight lines to the speeds at their times; follow: within the bounds, with an acceleration of 0 at each entry; with an entity the speeds are added to its own
    SpeedProfileAction -> Action
    ["followingMode" smooth: ProfileFollowingMode, "entityRef" relative_to: Option<EntityName>]
    {bounds: Option<DynamicConstraints>, entries: AtLeastOne<Placed<SpeedProfileEntry>>}
    {
        let backwards = entries.iter().find(|(_, entry)| relative_to.is_none() && entry.mps < 0.0);
        if let Some((place, SpeedEntry { mps, .. })) = backwards {
            let expected = "0 or more, or an `entityRef` whose speed it is added to";
            let reason = format!("the speed {mps} m/s is backwards");
            return Err(ReadError::meaning(place.clone(), reason, expected));
        }
        let entries = entries.into_iter().map(|(_, entry)| entry).collect();
        let bounds = bounds.unwrap_or(Bounds::NONE);
        Ok(Action::Profile(SpeedProfile { relative_to, smooth, bounds, entries }))
    }

    /// the time counts from the entry before; without one the speed is reached as soon as the bounds allow
    SpeedProfileEntry -> SpeedEntry
    ["speed" mps: Number as "m/s", "time" time_s: Option<AtLeastZero> as "s"] {}
    { Ok(SpeedEntry { mps, time_s }) }

    /// bounds on the way; a distance is there at once without both accelerations, and their rates have no effect on it
    DynamicConstraints -> Bounds
    ["maxAcceleration" up: Option<Bound> as "m/s²", "maxDeceleration" down: Option<Bound> as "m/s²",
        "maxAccelerationRate" up_rate: Option<Bound> as "m/s³",
        "maxDecelerationRate" down_rate: Option<Bound> as "m/s³",
        "maxSpeed" speed: Option<Bound> as "m/s"] {}
    {
        Ok(Bounds {
            acceleration_mps2: up.unwrap_or(f64::INFINITY),
            deceleration_mps2: down.unwrap_or(f64::INFINITY),
            acceleration_rate_mps3: up_rate.unwrap_or(f64::INFINITY),
            deceleration_rate_mps3: down_rate.unwrap_or(f64::INFINITY),
            speed_mps: speed.unwrap_or(f64::INFINITY),
        })
    }

    /// replaces the lateral action that is running
    LateralAction -> Action []
    {action: OneOf<(LaneChangeAction, LaneOffsetAction, LateralDistanceAction)>}

    /// beside the other entity, as that one faces: there with shape sinusoidal within the constraints, at once without; a missing distance is that of the start; continuous: kept until another lateral action
    LateralDistanceAction -> Action
    ["entityRef" entity: EntityName, "freespace" freespace: Truth, "continuous" continuous: Truth,
        "distance" distance_m: Option<AtLeastZero> as "m", "displacement" side: Option<LateralSide>,
        "coordinateSystem" _: Option<CoordinateSystem>]
    {bounds: Option<DynamicConstraints>}
    {
        let (bounds, side) = (bounds.unwrap_or(Bounds::NONE), side.unwrap_or(LateralSide::Any));
        let aside = Aside { entity, distance_m, freespace, side, most_mps: bounds.speed_mps };
        let (target, shape) = (OffsetTarget::Aside(aside), Shape::Sinusoidal);
        let most_mps2 = bounds.acceleration_mps2.min(bounds.deceleration_mps2);
        let max_lateral_mps2 = Some(most_mps2).filter(|most| most.is_finite());
        Ok(Action::LaneOffset { target, shape, max_lateral_mps2, continuous })
    }

    /// lateral position follows the shape to the lane's centre
    LaneChangeAction -> Action ["targetLaneOffset" offset_m: Option<Number> as "m"]
    {transition: LaneChangeActionDynamics, target: LaneChangeTarget}
    |node| {
        node.scene.add_exits(&node.place())?;
        Ok(Action::LaneChange { target, offset_m: offset_m.unwrap_or(0.0), transition })
    }

    /// the lane at the end
    LaneChangeTarget -> LaneTarget [] {target: OneOf<(AbsoluteTargetLane, RelativeTargetLane)>}

    /// a lane's id
    AbsoluteTargetLane -> LaneTarget ["value" id: Whole] {}
    |node| {
        let first = &node.scene.road(None)?.road;
        let roads = node.scene.roads();
        let mut sections = roads.iter().flat_map(|road| &road.lanes.sections);
        if !sections.any(|section| section.lanes.iter().any(|lane| lane.id == id)) {
            let reason = format!("road {} has no lane `{id}`", first.names());
            return Err(node.wrong("value", reason, first.lane_names(0.0)));
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

    /// the entity is at its target when the master is at its own, with the least acceleration for it, at most 20 m/s²; ends when the master is there or both are within their tolerances; at once if a target is not ahead
    SynchronizeAction -> Action
    ["masterEntityRef" master: Master, "targetToleranceMaster" near_master: Option<AtLeastZero> as "m",
        "targetTolerance" near: Option<AtLeastZero> as "m"]
    {master_goal: TargetPositionMaster, goal: TargetPosition, final_speed: Option<FinalSpeed>}
    {
        Ok(Action::Meet(Box::new(Meeting {
            master,
            master_goal,
            goal,
            master_tolerance_m: near_master.unwrap_or(0.0),
            tolerance_m: near.unwrap_or(0.0),
            final_speed,
        })))
    }

    /// the speed at the target; without one it is free
    FinalSpeed -> timed::FinalSpeed [] {speed: OneOf<(AbsoluteSpeed, RelativeSpeedToMaster)>}

    /// a speed
    AbsoluteSpeed -> timed::FinalSpeed ["value" mps: AtLeastZero as "m/s"]
    {steady: Option<OneOf<(TargetDistanceSteadyState, TargetTimeSteadyState)>>}
    |node| {
        if mps == 0.0 && steady.is_some() {
            let reason = "an entity that stands covers no last part of its way";
            return Err(node.wrong("value", reason, "more than 0, or no steady state"));
        }
        Ok(timed::FinalSpeed { speed: SpeedTarget::Absolute(mps), steady })
    }

    /// delta (m/s) or factor of the master's present speed
    RelativeSpeedToMaster -> timed::FinalSpeed
    ["value" value: Number, "speedTargetValueType" is_factor: SpeedTargetValueType]
    {steady: Option<OneOf<(TargetDistanceSteadyState, TargetTimeSteadyState)>>}
    |node| {
        let master = node.scene.master.get();
        Ok(timed::FinalSpeed { speed: relative(node, (master, is_factor, value), false)?, steady })
    }

    /// the last part of the way, covered with the final speed
    TargetDistanceSteadyState -> Steady ["distance" metres: AtLeastZero as "m"] {}
    { Ok(Steady::Distance(metres)) }

    /// the last part of the time, driven with the final speed
    TargetTimeSteadyState -> Steady ["time" time_s: AtLeastZero as "s"] {}
    { Ok(Steady::Time(time_s)) }
}

/// A speed that is a factor of another entity's, or differs from it by a value in m/s.
pub(super) fn relative(
    node: Node<'_>,
    (entity, is_factor, value): (usize, bool, f64),
    continuous: bool,
) -> Result<SpeedTarget, ReadError> {
    if is_factor && value < 0.0 {
        return Err(node.wrong("value", format!("{value} is negative"), "0 or more"));
    }
    let (factor, offset_mps) = if is_factor { (value, 0.0) } else { (1.0, value) };
    Ok(SpeedTarget::Relative { entity, factor, offset_mps, continuous })
}

scalars! {
    /// The entity that another one meets. Its final speed may count from the master's.
    Master -> usize: EntityName::kind(), |given| {
        let master = EntityName::take(given)?;
        given.node.scene.master.set(master);
        Ok(master)
    };
}
