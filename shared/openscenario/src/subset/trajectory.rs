//! Trajectories.

use super::catalog::FromCatalog;
use super::curve::{Clothoid, Nurbs};
use super::longitudinal::FollowingMode;
use super::position::Spot;
use super::route::{AcquirePositionAction, AssignRouteAction};
use crate::declare::{AtLeastOne, AtLeastZero, Number, OneOf, Positive, Truth, elements, words};
use crate::model::action::{self, Action, Vertex as Corner};
use crate::parameter::{ParameterDeclarations, Scoped};

words! {
    /// The origin of a time; its value is whether this is the start of the run.
    ReferenceContext = bool { "absolute" true, "relative" false }
}

elements! { "Actions";
    /// a trajectory replaces both the longitudinal and the lateral action
    RoutingAction -> Action []
    {action: OneOf<(FollowTrajectoryAction, AssignRouteAction, AcquirePositionAction)>}

    /// the entity moves along the trajectory, then goes straight on with its last speed
    FollowTrajectoryAction -> Action ["initialDistanceOffset" offset_m: Option<AtLeastZero> as "m"] {
        timing: Option<TimeReference>,
        _: Option<TrajectoryFollowingMode>,
        vertices: OneOf<(TrajectoryRef, Scoped<Trajectory>, FromCatalog<Trajectory>)>,
    } |node| {
        let (timing, initial_offset_m) = (timing.flatten(), offset_m.unwrap_or(0.0));
        let increase = vertices.is_sorted_by(|a, b| a.time_s < b.time_s);
        if timing.is_some() && !increase {
            let reason = "the times of the vertices do not increase";
            return Err(node.refuse(reason, "increasing times"));
        }
        if timing.is_some() && initial_offset_m > 0.0 {
            return Err(node.refuse("a timed trajectory has no initial offset", "no timing"));
        }
        Ok(Action::Trajectory(action::Trajectory { vertices, timing, initial_offset_m }))
    }

    /// the trajectory
    TrajectoryRef -> Vec<Corner> []
    {vertices: OneOf<(Scoped<Trajectory>, FromCatalog<Trajectory>)>}

    /// closed="false" only
    Trajectory -> Vec<Corner> ["closed" closed: Truth]
    {_: Option<ParameterDeclarations>, vertices: TrajectoryShape}
    unused ["name"]
    |node| {
        if closed {
            return Err(node.wrong("closed", "closed trajectories are not supported", "false"));
        }
        Ok(vertices)
    }

    /// the line
    TrajectoryShape = "Shape" -> Vec<Corner> [] {vertices: OneOf<(Polyline, Clothoid, Nurbs)>}

    /// straight pieces between two or more vertices
    Polyline -> Vec<Corner> [] {vertices: AtLeastOne<Vertex>}
    |node| {
        match vertices.len() {
            0 | 1 => Err(node.refuse("a line of one vertex", "two vertices or more")),
            _ => Ok(vertices),
        }
    }

    /// times increase; all or none have one
    Vertex -> Corner ["time" time_s: Option<Number> as "s"] {position: Spot}
    { Ok(Corner { time_s: time_s.unwrap_or(0.0), position }) }

    /// with timing the vertices' times set the speed, without it the entity keeps its own
    TimeReference -> Option<action::Timing> [] {timing: OneOf<(Untimed, Timing)>}

    /// no timing
    Untimed = "None" -> Option<action::Timing> [] {} { Ok(None) }

    /// time = scale * vertex time + offset, from the start of the run or of the action
    Timing -> Option<action::Timing>
    ["domainAbsoluteRelative" absolute: ReferenceContext, "scale" scale: Positive,
        "offset" offset_s: Number as "s"] {}
    { Ok(Some(action::Timing { absolute, scale, offset_s })) }

    /// follow and position do the same
    TrajectoryFollowingMode -> () ["followingMode" _: FollowingMode] {}
}
