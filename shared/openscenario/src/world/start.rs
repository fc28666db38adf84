//! How actions begin and end.

use std::sync::Arc;

use crate::model::action::{
    Action, Change, Dimension, LaneTarget, OffsetTarget, Shape, SpeedTarget, Trajectory, Transition,
};
use crate::model::element::ElementState;
use crate::model::position::{From, Heading, Position};
use crate::model::{Category, MAX_ENTITIES, Script};
use crate::world::motion::{
    Course, LateralShape, MAX_SPEED_MPS, Pace, Path, SpeedShape, Steer, seconds,
};
use crate::world::state::Motion;
use crate::world::{World, WorldError};

/// A transition that takes no time.
pub(super) fn is_immediate(transition: &Transition) -> bool {
    transition.shape == Shape::Step
        || (transition.dimension != Dimension::Rate && transition.value == 0.0)
}

impl World {
    /// Places the entities of Init's teleports, each after the one that it is placed from.
    pub(super) fn place(&mut self) -> Result<(), WorldError> {
        let script = Arc::clone(&self.script);
        let mut open: Vec<(usize, &Position)> = Vec::new();
        for item in &script.init {
            match (&item.action, item.actor) {
                (Action::Teleport(position), Some(actor)) => open.push((actor, position)),
                (Action::Add { entity, position }, _) => open.push((*entity, position)),
                _ => {}
            }
        }
        while !open.is_empty() {
            let waits = |position: &Position, open: &[(usize, &Position)]| {
                reference(position)
                    .is_some_and(|other| open.iter().any(|(actor, _)| *actor == other))
            };
            let Some(next) = open.iter().position(|(_, position)| !waits(position, &open)) else {
                let entity = script.entities[open[0].0].name.clone();
                let reason = "the entities that it is placed from depend on each other";
                return Err(WorldError::Placement { entity, reason });
            };
            let (actor, position) = open.remove(next);
            let Some((s_m, t_m, heading_rad)) = self.resolve(position) else {
                let entity = script.entities[actor].name.clone();
                let reason = "the lane or the entity that it is placed from is not there";
                return Err(WorldError::Placement { entity, reason });
            };
            fits_its_lane(&script, actor, t_m)?;
            let motion = &mut self.state.movers[actor].motion;
            *motion = Motion { present: true, s_m, t_m, heading_rad, ..*motion };
        }
        Ok(())
    }

    /// Sets the speeds that Init sets at once, each after the one that it depends on.
    pub(super) fn first_speeds(&mut self) -> Result<(), WorldError> {
        let script = Arc::clone(&self.script);
        let mut open: Vec<(usize, &SpeedTarget)> = Vec::new();
        for item in &script.init {
            if let (Action::Speed { target, transition }, Some(actor)) = (&item.action, item.actor)
                && self.at_once(transition, target)
            {
                open.push((actor, target));
            }
        }
        while !open.is_empty() {
            let waits = |target: &SpeedTarget, open: &[(usize, &SpeedTarget)]| match target {
                SpeedTarget::Absolute(_) => false,
                SpeedTarget::Delta { entity, .. } | SpeedTarget::Factor { entity, .. } => {
                    open.iter().any(|(actor, _)| actor == entity)
                }
            };
            let Some(next) = open.iter().position(|(_, target)| !waits(target, &open)) else {
                let entity = script.entities[open[0].0].name.clone();
                return Err(WorldError::Speed { entity });
            };
            let (actor, target) = open.remove(next);
            self.state.movers[actor].motion.speed_mps = self.target_speed(target);
        }
        Ok(())
    }

    /// Begins an action for its actors. `element` is the storyboard's action that it belongs to.
    pub(super) fn start(&mut self, action: &Action, actors: &[usize], element: Option<usize>) {
        let before = self.count(element);
        match action {
            Action::Set { value, change } => self.change(*value, change),
            Action::Add { entity, position } => self.teleport(*entity, position),
            Action::Delete { entity } => self.delete(*entity),
            Action::Nothing => {}
            _ => {
                for &actor in actors {
                    self.begin(action, actor, element);
                }
            }
        }
        if self.count(element) == before {
            self.finish(element, ElementState::EndTransition);
        }
    }

    fn begin(&mut self, action: &Action, actor: usize, element: Option<usize>) {
        match action {
            Action::Teleport(position) => self.teleport(actor, position),
            Action::Speed { target, transition } => {
                self.begin_speed(actor, target, transition, element)
            }
            Action::Distance(distance) => {
                if distance.limits.is_none() && !distance.continuous {
                    self.clear_pace(actor);
                    if let Some(goal) = self.gap_goal(actor, distance)
                        && !self.is_external(actor)
                    {
                        self.state.movers[actor].motion.s_m = goal;
                    }
                } else {
                    self.set_pace(actor, Pace::Keep(*distance), element);
                }
            }
            Action::LaneChange { target, offset_m, transition } => {
                if let Some(to_t_m) = self.lane_goal(actor, target) {
                    self.begin_lane_change(actor, to_t_m + offset_m, transition, element);
                }
            }
            Action::LaneOffset { target, shape, max_lateral_mps2, continuous } => {
                let (to_t_m, follow) = match target {
                    OffsetTarget::Lane(offset_m) => {
                        let t_m = self.motion(actor).t_m;
                        let lane = self.script.road.index_at(t_m);
                        let center = self.script.road.lanes.get(lane).map_or(0.0, |l| l.center_m);
                        (center + offset_m, None)
                    }
                    OffsetTarget::Entity { entity, offset_m } => {
                        (self.motion(*entity).t_m + offset_m, Some((*entity, *offset_m)))
                    }
                };
                let from_t_m = self.motion(actor).t_m;
                let duration_s = match max_lateral_mps2 {
                    Some(most) if *shape != Shape::Step => {
                        libm::sqrt((to_t_m - from_t_m).abs() * shape.largest_curvature() / most)
                    }
                    _ => 0.0,
                };
                let by = Course::Time { start_ns: self.state.time_ns, duration_s };
                let endless = continuous.then_some(follow);
                let shape = LateralShape { from_t_m, to_t_m, by, shape: *shape, endless };
                self.set_steer(actor, shape, duration_s <= 0.0, element);
            }
            Action::Trajectory(trajectory) => self.begin_path(actor, trajectory, element),
            Action::Set { .. } | Action::Add { .. } | Action::Delete { .. } | Action::Nothing => {}
        }
    }

    fn begin_speed(
        &mut self,
        actor: usize,
        target: &SpeedTarget,
        transition: &Transition,
        element: Option<usize>,
    ) {
        let to_mps = self.target_speed(target);
        let from_mps = self.motion(actor).speed_mps;
        let (entity, factor, offset_mps) = match *target {
            SpeedTarget::Delta { entity, mps, continuous: true } => (entity, 1.0, mps),
            SpeedTarget::Factor { entity, factor, continuous: true } => (entity, factor, 0.0),
            _ => {
                let change = (to_mps - from_mps).abs();
                let duration_s =
                    match (is_immediate(transition) || change == 0.0, transition.dimension) {
                        (true, _) => 0.0,
                        (_, Dimension::Time) => transition.value,
                        (_, Dimension::Rate) => {
                            transition.shape.largest_rate() * change / transition.value
                        }
                        // All shapes are symmetric: the mean speed is the mean of both ends.
                        (_, Dimension::Distance) => 2.0 * transition.value / (from_mps + to_mps),
                    };
                if duration_s <= 0.0 {
                    self.clear_pace(actor);
                    if !self.is_external(actor) {
                        self.state.movers[actor].motion.speed_mps = to_mps;
                    }
                    return;
                }
                let start_ns = self.state.time_ns;
                let shape =
                    SpeedShape { from_mps, to_mps, start_ns, duration_s, shape: transition.shape };
                self.set_pace(actor, Pace::Shape(shape), element);
                return;
            }
        };
        let rate_mps2 = match transition.dimension {
            Dimension::Rate if transition.shape != Shape::Step => transition.value,
            _ => f64::INFINITY,
        };
        self.set_pace(actor, Pace::Match { entity, factor, offset_mps, rate_mps2 }, element);
    }

    fn begin_lane_change(
        &mut self,
        actor: usize,
        to_t_m: f64,
        transition: &Transition,
        element: Option<usize>,
    ) {
        let from_t_m = self.motion(actor).t_m;
        let change = (to_t_m - from_t_m).abs();
        let start_ns = self.state.time_ns;
        let start_m = self.state.movers[actor].odometer_m;
        let immediate = is_immediate(transition) || change == 0.0;
        let by = match transition.dimension {
            _ if immediate => Course::Time { start_ns, duration_s: 0.0 },
            Dimension::Time => Course::Time { start_ns, duration_s: transition.value },
            Dimension::Rate => {
                let duration_s = transition.shape.largest_rate() * change / transition.value;
                Course::Time { start_ns, duration_s }
            }
            Dimension::Distance => Course::Way { start_m, length_m: transition.value },
        };
        let shape = LateralShape { from_t_m, to_t_m, by, shape: transition.shape, endless: None };
        self.set_steer(actor, shape, immediate, element);
    }

    fn begin_path(&mut self, actor: usize, trajectory: &Trajectory, element: Option<usize>) {
        let start_s = seconds(self.state.time_ns);
        let mut corners = Vec::with_capacity(trajectory.vertices.len());
        let mut way_m = -trajectory.initial_offset_m;
        for vertex in &trajectory.vertices {
            let Some((s_m, t_m, _)) = self.resolve(&vertex.position) else { continue };
            let at = match &trajectory.timing {
                Some(timing) => {
                    let base = if timing.absolute { 0.0 } else { start_s };
                    base + timing.scale * vertex.time_s + timing.offset_s
                }
                None => {
                    if let Some(&(_, s, t)) = corners.last() {
                        way_m += libm::hypot(s_m - s, t_m - t);
                    }
                    way_m
                }
            };
            if corners.last().is_none_or(|&(last, _, _): &(f64, f64, f64)| last < at) {
                corners.push((at, s_m, t_m));
            }
        }
        if corners.len() < 2 {
            return;
        }
        let timed = trajectory.timing.is_some();
        if timed {
            self.clear_pace(actor);
        }
        self.clear_steer(actor);
        self.clear_path(actor);
        let by_way_from_m = (!timed).then_some(self.state.movers[actor].odometer_m);
        let mover = &mut self.state.movers[actor];
        mover.path = Some(Path { corners, by_way_from_m });
        mover.path_owner = element;
        self.hold(element);
    }

    fn set_pace(&mut self, actor: usize, pace: Pace, element: Option<usize>) {
        self.clear_pace(actor);
        let mover = &mut self.state.movers[actor];
        mover.pace = pace;
        mover.pace_owner = element;
        self.hold(element);
    }

    fn set_steer(
        &mut self,
        actor: usize,
        shape: LateralShape,
        immediate: bool,
        element: Option<usize>,
    ) {
        self.clear_steer(actor);
        self.clear_path(actor);
        if immediate && !self.is_external(actor) {
            self.state.movers[actor].motion.t_m = shape.to_t_m;
        }
        if immediate && shape.endless.is_none() {
            return;
        }
        let mover = &mut self.state.movers[actor];
        mover.steer = Steer::Shape(shape);
        mover.steer_owner = element;
        self.hold(element);
    }

    /// Ends what runs, because something else takes its place. A timed line is longitudinal too.
    fn clear_pace(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.pace = Pace::Free;
        let owner = mover.pace_owner.take();
        self.release(owner, ElementState::StopTransition);
        if self.state.movers[actor].path.as_ref().is_some_and(|path| path.by_way_from_m.is_none()) {
            self.clear_path(actor);
        }
    }

    fn clear_steer(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.steer = Steer::Hold;
        mover.motion.lateral_mps = 0.0;
        let owner = mover.steer_owner.take();
        self.release(owner, ElementState::StopTransition);
    }

    fn clear_path(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.path = None;
        let owner = mover.path_owner.take();
        self.release(owner, ElementState::StopTransition);
    }

    /// Ends what has reached its end.
    pub(super) fn end_pace(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.pace = Pace::Free;
        mover.motion.acceleration_mps2 = match self.script.entities[actor].drive {
            crate::model::Drive::Scripted => 0.0,
            crate::model::Drive::External => mover.motion.acceleration_mps2,
        };
        let owner = mover.pace_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    pub(super) fn end_steer(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.steer = Steer::Hold;
        let owner = mover.steer_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    pub(super) fn end_path(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.path = None;
        let owner = mover.path_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    /// Ends everything that a storyboard's action does, because its event is stopped.
    pub(super) fn abandon(&mut self, element: usize) {
        for actor in 0..self.state.movers.len() {
            let mover = &self.state.movers[actor];
            let owns = |owner: Option<usize>| owner == Some(element);
            let (pace, steer, path) =
                (owns(mover.pace_owner), owns(mover.steer_owner), owns(mover.path_owner));
            if pace {
                self.clear_pace(actor);
            }
            if steer {
                self.clear_steer(actor);
            }
            if path {
                self.clear_path(actor);
            }
        }
    }

    fn change(&mut self, value: usize, change: &Change) {
        let slot = &mut self.state.values[value];
        match (change, slot.number()) {
            (Change::To(new), _) => *slot = new.clone(),
            (Change::Add(by), Some(number)) => *slot = crate::Value::Number(number + by),
            (Change::Multiply(by), Some(number)) => *slot = crate::Value::Number(number * by),
            (Change::Add(_) | Change::Multiply(_), None) => {}
        }
    }

    fn teleport(&mut self, actor: usize, position: &Position) {
        if self.is_external(actor) {
            return;
        }
        if let Some((s_m, t_m, heading_rad)) = self.resolve(position) {
            let motion = &mut self.state.movers[actor].motion;
            *motion = Motion { present: true, s_m, t_m, heading_rad, ..*motion };
        }
    }

    fn delete(&mut self, entity: usize) {
        if !self.is_external(entity) {
            self.clear_pace(entity);
            self.clear_steer(entity);
            self.clear_path(entity);
            self.state.movers[entity].motion = Motion::default();
        }
    }

    fn target_speed(&self, target: &SpeedTarget) -> f64 {
        let speed = match *target {
            SpeedTarget::Absolute(mps) => mps,
            SpeedTarget::Delta { entity, mps, .. } => self.motion(entity).speed_mps + mps,
            SpeedTarget::Factor { entity, factor, .. } => self.motion(entity).speed_mps * factor,
        };
        speed.clamp(0.0, MAX_SPEED_MPS)
    }

    /// The lateral position at which a lane change ends, where there is such a lane.
    fn lane_goal(&self, _actor: usize, target: &LaneTarget) -> Option<f64> {
        let road = &self.script.road;
        match *target {
            LaneTarget::Lane(id) => road.lane(id).map(|lane| lane.center_m),
            LaneTarget::Lateral(t_m) => Some(t_m),
            LaneTarget::Beside { entity, lanes_left } => {
                let other = self.motion(entity);
                let left = if other.direction() > 0.0 { lanes_left } else { -lanes_left };
                road.lane_beside(other.t_m, left).map(|lane| lane.center_m)
            }
        }
    }

    /// `s`, `t` and heading of a position, where the entity that it is seen from is on the road.
    pub(super) fn resolve(&self, position: &Position) -> Option<(f64, f64, f64)> {
        let other = |entity: usize| Some(self.motion(entity)).filter(|motion| motion.present);
        let (s_m, t_m) = match position.from {
            From::Road { s_m, t_m } => (s_m, t_m),
            From::EntityOnRoad { entity, ds_m, dt_m } => {
                let other = other(entity)?;
                (other.s_m + ds_m, other.t_m + dt_m)
            }
            From::Entity { entity, ahead_m, left_m } => {
                let other = other(entity)?;
                let (sin, cos) = (libm::sin(other.heading_rad), libm::cos(other.heading_rad));
                (other.s_m + ahead_m * cos - left_m * sin, other.t_m + ahead_m * sin + left_m * cos)
            }
            From::EntityLane { entity, lanes_left, ds_m, offset_m } => {
                let other = other(entity)?;
                let direction = other.direction();
                let left = if direction > 0.0 { lanes_left } else { -lanes_left };
                let lane = self.script.road.lane_beside(other.t_m, left)?;
                (other.s_m + direction * ds_m, lane.center_m + offset_m)
            }
        };
        let heading_rad = match position.heading {
            Heading::Road(heading_rad) => heading_rad,
            Heading::Entity(heading_rad) => {
                heading_rad + reference(position).map_or(0.0, |e| self.motion(e).heading_rad)
            }
        };
        Some((s_m, t_m, heading_rad))
    }
}

/// Checks that a vehicle that is placed on a lane is not wider than that.
fn fits_its_lane(script: &Script, actor: usize, t_m: f64) -> Result<(), WorldError> {
    let (entity, road) = (&script.entities[actor], &script.road);
    let width_m = entity.body.width_m;
    let Some(lane) = road.lanes.get(road.index_at(t_m)).filter(|_| road.holds(t_m)) else {
        return Ok(());
    };
    if entity.category == Category::Vehicle && width_m > lane.width_m {
        let (entity, lane_m) = (entity.name.clone(), lane.width_m);
        return Err(WorldError::Width { entity, width_m, lane: lane.id, lane_m });
    }
    Ok(())
}

/// The entity that a position is seen from.
fn reference(position: &Position) -> Option<usize> {
    match position.from {
        From::Road { .. } => None,
        From::EntityOnRoad { entity, .. }
        | From::Entity { entity, .. }
        | From::EntityLane { entity, .. } => Some(entity),
    }
}

/// Checks that every index of a script's actions is inside its list.
pub(super) fn check(script: &Script) -> Result<(), WorldError> {
    let entities = script.entities.len();
    index("entity", script.ego, entities)?;
    index("number of entities", entities, MAX_ENTITIES + 1)?;
    for item in &script.init {
        for &actor in item.actor.as_slice() {
            index("entity", actor, entities)?;
        }
        check_action(script, &item.action)?;
    }
    let groups = script.stories.iter().flat_map(|story| &story.acts).flat_map(|act| &act.groups);
    for group in groups {
        for &actor in &group.actors {
            index("entity", actor, entities)?;
        }
        let events = group.maneuvers.iter().flat_map(|maneuver| &maneuver.events);
        for named in events.flat_map(|event| &event.actions) {
            check_action(script, &named.action)?;
        }
    }
    Ok(())
}

fn check_action(script: &Script, action: &Action) -> Result<(), WorldError> {
    let entities = script.entities.len();
    let at = |position: &Position| match reference(position) {
        Some(entity) => index("entity", entity, entities),
        None => Ok(()),
    };
    match action {
        Action::Speed { target: SpeedTarget::Delta { entity, .. }, .. }
        | Action::Speed { target: SpeedTarget::Factor { entity, .. }, .. }
        | Action::LaneChange { target: LaneTarget::Beside { entity, .. }, .. }
        | Action::LaneOffset { target: OffsetTarget::Entity { entity, .. }, .. }
        | Action::Delete { entity } => index("entity", *entity, entities),
        Action::Distance(distance) => index("entity", distance.entity, entities),
        Action::Teleport(position) => at(position),
        Action::Add { entity, position } => {
            index("entity", *entity, entities)?;
            at(position)
        }
        Action::Trajectory(line) => {
            line.vertices.iter().try_for_each(|vertex| at(&vertex.position))
        }
        Action::Set { value, .. } => index("value", *value, script.values.len()),
        Action::Speed { .. }
        | Action::LaneChange { .. }
        | Action::LaneOffset { .. }
        | Action::Nothing => Ok(()),
    }
}

/// Checks that an index is inside its list.
pub(super) fn index(what: &'static str, index: usize, count: usize) -> Result<(), WorldError> {
    if index < count { Ok(()) } else { Err(WorldError::Index { what, index, count }) }
}
