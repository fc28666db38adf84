//! Actions.

use super::Reader;
use crate::error::ReadError;
use crate::model::action::{
    Action, Change, Dimension, Distance, Gap, LaneTarget, Limits, OffsetTarget, Shape, Side,
    SpeedTarget, Timing, Trajectory, Transition, Vertex,
};
use crate::node::Node;

const SHAPES: &[(&str, Shape)] = &[
    ("linear", Shape::Linear),
    ("cubic", Shape::Cubic),
    ("sinusoidal", Shape::Sinusoidal),
    ("step", Shape::Step),
];

impl Reader<'_> {
    /// What a `PrivateAction` does; a controller action may hold two, which both do nothing.
    pub(super) fn private(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let kind = node.children().next().expect("the subset demands one");
        let inner = || kind.children().next().expect("the subset demands one");
        match kind.name() {
            "LongitudinalAction" => match inner() {
                speed if speed.name() == "SpeedAction" => self.speed(speed),
                distance => self.distance(distance),
            },
            "LateralAction" => match inner() {
                change if change.name() == "LaneChangeAction" => self.lane_change(change),
                offset => self.lane_offset(offset),
            },
            "TeleportAction" => self.position_in(kind).map(Action::Teleport),
            "RoutingAction" => self.trajectory(inner()),
            "ControllerAction" => self.controller(kind),
            _ => Ok(Action::Nothing),
        }
    }

    /// Checks a `ControllerAction`, which does nothing.
    fn controller(&self, node: Node<'_>) -> Result<Action, ReadError> {
        if node.children().next().is_none() {
            return Err(node.refuse(
                "`ControllerAction` is empty",
                "`AssignControllerAction` or `ActivateControllerAction`",
            ));
        }
        if let Some(assign) = node.child_if("AssignControllerAction") {
            let holder = assign.child_if("ObjectController").unwrap_or(assign);
            if let Some(reference) = holder.child_if("CatalogReference") {
                let locations = self.root.child_if("CatalogLocations");
                let found = &mut |_: Node<'_>| Ok(());
                self.library.entry(reference, locations, &["Controller"], found)?;
            }
        }
        if let Some(overridden) = node.child_if("OverrideControllerValueAction") {
            for value in overridden.children() {
                if value.boolean("active")? {
                    let reason = format!("`{}` would be overridden", value.name());
                    return Err(value.fault("active").error(reason, "false"));
                }
            }
        }
        Ok(Action::Nothing)
    }

    /// Checks an `EnvironmentAction`, which does nothing.
    fn environment(&self, what: Node<'_>) -> Result<Action, ReadError> {
        let check = |environment: Node<'_>| {
            let Some(road) = environment.child_if("RoadCondition") else { return Ok(()) };
            match road.number("frictionScaleFactor")? {
                1.0 => Ok(()),
                factor => Err(road
                    .fault("frictionScaleFactor")
                    .error(format!("{factor} would change the brakes"), "1")),
            }
        };
        if what.name() == "CatalogReference" {
            let locations = self.root.child_if("CatalogLocations");
            self.library.entry(what, locations, &["Environment"], &mut |entry| check(entry))?;
        } else {
            let scope = what.scope.with(what.file, what.element, &[])?;
            check(Node { scope: &scope, ..what })?;
        }
        Ok(Action::Nothing)
    }

    /// What a `GlobalAction` does.
    pub(super) fn global(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let kind = node.children().next().expect("the subset demands one");
        let what = kind.children().next().expect("the subset demands one");
        if kind.name() == "EnvironmentAction" {
            return self.environment(what);
        }
        if kind.name() == "EntityAction" {
            let entity = self.entity_ref(kind)?;
            if entity == self.ego {
                return Err(kind.refuse("the ego is always on the road", "another entity"));
            }
            return Ok(match what.name() {
                "AddEntityAction" => Action::Add { entity, position: self.position_in(what)? },
                _ => Action::Delete { entity },
            });
        }
        let attribute = match kind.name() {
            "ParameterAction" => "parameterRef",
            _ => "variableRef",
        };
        let value = self.value_ref(kind, attribute)?;
        let change = match what.name() {
            "SetAction" => Change::To(what.value("value")?.expect("the subset demands it")),
            _ => {
                let rule = what.child("Rule")?.children().next().expect("the subset demands one");
                if self.values.borrow()[value].value.number().is_none() {
                    return Err(rule.refuse("this value is not a number", "a number to modify"));
                }
                match rule.name() {
                    "AddValue" => Change::Add(rule.number("value")?),
                    _ => Change::Multiply(rule.number("value")?),
                }
            }
        };
        Ok(Action::Set { value, change })
    }

    fn speed(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let transition = transition(node.child("SpeedActionDynamics")?)?;
        let goal = node.child("SpeedActionTarget")?.children().next();
        let goal = goal.expect("the subset demands one");
        let target = match goal.name() {
            "AbsoluteTargetSpeed" => SpeedTarget::Absolute(goal.magnitude("value")?),
            _ => {
                let entity = self.entity_ref(goal)?;
                let continuous = goal.boolean("continuous")?;
                if continuous
                    && transition.shape != Shape::Step
                    && transition.dimension != Dimension::Rate
                {
                    return Err(goal.refuse(
                        "a continuous target has no time or distance at which it is reached",
                        "shape step or dimension rate",
                    ));
                }
                if goal.word("speedTargetValueType", &[("delta", false), ("factor", true)])? {
                    let factor = goal.magnitude("value")?;
                    SpeedTarget::Factor { entity, factor, continuous }
                } else {
                    SpeedTarget::Delta { entity, mps: goal.number("value")?, continuous }
                }
            }
        };
        Ok(Action::Speed { target, transition })
    }

    fn distance(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let has = |attribute| node.element.attribute(attribute).is_some();
        let gap = match (has("distance"), has("timeGap")) {
            (true, false) => Gap::Distance(node.magnitude("distance")?),
            (false, true) => Gap::Time(node.magnitude("timeGap")?),
            _ => {
                let reason = "`LongitudinalDistanceAction` has both or none of its two measures";
                return Err(node.refuse(reason, "either `distance` or `timeGap`"));
            }
        };
        let sides = [
            ("any", Side::Any),
            ("trailingReferencedEntity", Side::Behind),
            ("leadingReferencedEntity", Side::Ahead),
        ];
        let systems = [("entity", ()), ("lane", ()), ("road", ())];
        node.word_if("coordinateSystem", &systems)?;
        let limits = match node.child_if("DynamicConstraints") {
            None => None,
            Some(bounds) => Some(Limits {
                max_acceleration_mps2: bound(bounds, "maxAcceleration")?,
                max_deceleration_mps2: bound(bounds, "maxDeceleration")?,
                max_speed_mps: bound(bounds, "maxSpeed")?,
            }),
        };
        let unbounded = |limits: &Limits| {
            limits.max_acceleration_mps2.is_infinite() || limits.max_deceleration_mps2.is_infinite()
        };
        Ok(Action::Distance(Distance {
            entity: self.entity_ref(node)?,
            gap,
            freespace: node.boolean("freespace")?,
            side: node.word_if("displacement", &sides)?.unwrap_or(Side::Behind),
            continuous: node.boolean("continuous")?,
            limits: limits.filter(|limits| !unbounded(limits)),
        }))
    }

    fn lane_change(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let goal = node.child("LaneChangeTarget")?.children().next();
        let goal = goal.expect("the subset demands one");
        let target = match goal.name() {
            "AbsoluteTargetLane" => {
                let id = goal.integer("value")?;
                let road = self.any_road()?;
                if road.lane(id).is_none() {
                    let known: Vec<String> = road.lanes.iter().map(|l| l.id.to_string()).collect();
                    return Err(goal.fault("value").error(
                        format!("road `{}` has no lane `{id}`", road.id),
                        crate::error::one_of(known.iter().map(String::as_str)),
                    ));
                }
                LaneTarget::Lane(id)
            }
            _ => LaneTarget::Beside {
                entity: self.entity_ref(goal)?,
                lanes_left: goal.integer("value")?,
            },
        };
        Ok(Action::LaneChange {
            target,
            offset_m: node.number_or("targetLaneOffset", 0.0)?,
            transition: transition(node.child("LaneChangeActionDynamics")?)?,
        })
    }

    fn lane_offset(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let dynamics = node.child("LaneOffsetActionDynamics")?;
        let shape = dynamics.word("dynamicsShape", SHAPES)?;
        let max_lateral_mps2 = match dynamics.number_if("maxLateralAcc")? {
            None => None,
            Some(rate) if rate.is_infinite() && rate > 0.0 => None,
            Some(rate) if rate > 0.0 => Some(rate),
            Some(rate) => {
                let fault = dynamics.fault("maxLateralAcc");
                return Err(fault.error(format!("{rate} m/s²"), "more than 0"));
            }
        };
        if shape == Shape::Linear && max_lateral_mps2.is_some() {
            return Err(dynamics.refuse(
                "a linear offset has no bounded lateral acceleration",
                "shape cubic, sinusoidal or step, or no `maxLateralAcc`",
            ));
        }
        let goal = node.child("LaneOffsetTarget")?.children().next();
        let goal = goal.expect("the subset demands one");
        let target = match goal.name() {
            "AbsoluteTargetLaneOffset" => OffsetTarget::Lane(goal.number("value")?),
            _ => OffsetTarget::Entity {
                entity: self.entity_ref(goal)?,
                offset_m: goal.number("value")?,
            },
        };
        let continuous = node.boolean("continuous")?;
        Ok(Action::LaneOffset { target, shape, max_lateral_mps2, continuous })
    }

    fn trajectory(&self, node: Node<'_>) -> Result<Action, ReadError> {
        let holder = node.child_if("TrajectoryRef").unwrap_or(node);
        let what = holder.chosen(&["Trajectory", "CatalogReference"])?;
        let vertices = if what.name() == "CatalogReference" {
            let locations = self.root.child_if("CatalogLocations");
            let found = &mut |entry: Node<'_>| self.vertices(entry);
            self.library.entry(what, locations, &["Trajectory"], found)?
        } else {
            let scope = what.scope.with(what.file, what.element, &[])?;
            self.vertices(Node { scope: &scope, ..what })?
        };
        let timing = match node.child_if("TimeReference").and_then(|t| t.child_if("Timing")) {
            None => None,
            Some(timing) => {
                let domains = [("absolute", true), ("relative", false)];
                let scale = timing.number("scale")?;
                if !(scale > 0.0) {
                    return Err(timing.fault("scale").error(format!("{scale}"), "more than 0"));
                }
                Some(Timing {
                    absolute: timing.word("domainAbsoluteRelative", &domains)?,
                    scale,
                    offset_s: timing.number("offset")?,
                })
            }
        };
        if timing.is_some() && vertices.windows(2).any(|pair| pair[0].time_s >= pair[1].time_s) {
            return Err(
                what.refuse("the times of the vertices do not increase", "increasing times")
            );
        }
        if let Some(mode) = node.child_if("TrajectoryFollowingMode") {
            mode.word("followingMode", &[("follow", ()), ("position", ())])?;
        }
        let initial_offset_m = match node.element.attribute("initialDistanceOffset") {
            Some(_) => node.magnitude("initialDistanceOffset")?,
            None => 0.0,
        };
        if timing.is_some() && initial_offset_m > 0.0 {
            return Err(node.refuse("a timed trajectory has no initial offset", "no timing"));
        }
        Ok(Action::Trajectory(Trajectory { vertices, timing, initial_offset_m }))
    }

    fn vertices(&self, trajectory: Node<'_>) -> Result<Vec<Vertex>, ReadError> {
        if trajectory.boolean("closed")? {
            let fault = trajectory.fault("closed");
            return Err(fault.error("closed trajectories are not supported", "false"));
        }
        let line = trajectory.child("Shape")?.child("Polyline")?;
        let mut vertices = Vec::new();
        for vertex in line.children() {
            let time_s = vertex.number_or("time", 0.0)?;
            vertices.push(Vertex { time_s, position: self.position_in(vertex)? });
        }
        if vertices.len() < 2 {
            return Err(line.refuse("a line of one vertex", "two vertices or more"));
        }
        Ok(vertices)
    }
}

fn transition(node: Node<'_>) -> Result<Transition, ReadError> {
    let dimensions =
        [("time", Dimension::Time), ("rate", Dimension::Rate), ("distance", Dimension::Distance)];
    let dimension = node.word("dynamicsDimension", &dimensions)?;
    let value = node.number("value")?;
    if value < 0.0 && dimension != Dimension::Rate {
        return Err(node.fault("value").error(format!("{value} is negative"), "0 or more"));
    }
    node.word_if("followingMode", &[("follow", ()), ("position", ())])?;
    let shape = node.word("dynamicsShape", SHAPES)?;
    Ok(Transition { shape, dimension, value: value.abs() })
}

/// A bound that may be absent or infinite.
fn bound(node: Node<'_>, attribute: &'static str) -> Result<f64, ReadError> {
    match node.number_if(attribute)? {
        None => Ok(f64::INFINITY),
        Some(bound) if bound > 0.0 => Ok(bound),
        Some(bound) => Err(node.fault(attribute).error(format!("{bound}"), "more than 0")),
    }
}
