//! Arrivals at the same time.

use super::position::Position;
use super::reference::EntityName;
use crate::declare::{AtLeastZero, Element, Form, Node, Number, OneOf, elements, words};
use crate::error::ReadError;
use crate::model::action::Action;
use crate::model::meeting::{self, Meeting, MeetingSpeed, Steady};
use crate::model::position;

words! {
    /// Meaning of a final speed; the value is true for a factor.
    FinalSpeedType = bool { "delta" false, "factor" true }
}

elements! { "Actions";
    /// the entity is at its target when the master is at its own, with the least acceleration for it, at most 20 m/s²; ends when the master is there or both are within their tolerances; at once if a target is not ahead
    SynchronizeAction -> Action
    ["masterEntityRef" master: EntityName, "targetToleranceMaster" near_master: Option<AtLeastZero> as "m",
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
    FinalSpeed -> meeting::FinalSpeed [] {speed: OneOf<(AbsoluteSpeed, RelativeSpeedToMaster)>}
    { Ok(speed) }

    /// a speed
    AbsoluteSpeed -> meeting::FinalSpeed ["value" mps: AtLeastZero as "m/s"]
    {steady: Option<OneOf<(TargetDistanceSteadyState, TargetTimeSteadyState)>>}
    |node| {
        if mps == 0.0 && steady.is_some() {
            let reason = "an entity that stands covers no last part of its way";
            return Err(node.wrong("value", reason, "more than 0, or no steady state"));
        }
        Ok(meeting::FinalSpeed { speed: MeetingSpeed::Absolute(mps), steady })
    }

    /// delta (m/s) or factor of the master's present speed
    RelativeSpeedToMaster -> meeting::FinalSpeed
    ["value" value: Number, "speedTargetValueType" is_factor: FinalSpeedType]
    {steady: Option<OneOf<(TargetDistanceSteadyState, TargetTimeSteadyState)>>}
    |node| {
        let speed = match is_factor {
            true if value < 0.0 => {
                return Err(node.wrong("value", format!("{value} is negative"), "0 or more"));
            }
            true => MeetingSpeed::Factor(value),
            false => MeetingSpeed::Delta(value),
        };
        Ok(meeting::FinalSpeed { speed, steady })
    }

    /// the last part of the way, covered with the final speed
    TargetDistanceSteadyState -> Steady ["distance" metres: AtLeastZero as "m"] {}
    { Ok(Steady::Distance(metres)) }

    /// the last part of the time, driven with the final speed
    TargetTimeSteadyState -> Steady ["time" time_s: AtLeastZero as "s"] {}
    { Ok(Steady::Time(time_s)) }
}

/// A position under another name.
macro_rules! positions {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        pub(crate) struct $name;

        impl Element for $name {
            const NAME: &'static str = stringify!($name);
            const FORM: &'static Form = Position::FORM;
            type Value = position::Position;

            fn read(node: Node<'_>) -> Result<position::Position, ReadError> {
                Position::read(node)
            }
        }
    )*};
}

positions! {
    /// The goal of the master.
    TargetPositionMaster
    /// The goal of the entity.
    TargetPosition
}
