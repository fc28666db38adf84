//! Arrivals at the same time.

use super::along::{TargetPosition, TargetPositionMaster};
use super::longitudinal::{SpeedTargetValueType, relative};
use super::reference::EntityName;
use crate::declare::{AtLeastZero, Number, OneOf, elements, scalars};
use crate::model::action::Action;
use crate::model::timed::SpeedTarget;
use crate::model::timed::{self, Meeting, Steady};

elements! { "Actions";
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

scalars! {
    /// The entity that another one meets. Its final speed may count from the master's.
    Master -> usize: EntityName::kind(), |given| {
        let master = EntityName::take(given)?;
        given.node.scene.master.set(master);
        Ok(master)
    };
}
