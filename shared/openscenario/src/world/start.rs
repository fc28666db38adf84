//! Begins of actions.

use std::sync::Arc;

use road::Pose;

use crate::model::Category;
use crate::model::action::{
    Action, Aside, Change, Dimension, LateralSide, OffsetTarget, Shape, Trajectory, Transition,
};
use crate::model::condition::ElementState;
use crate::model::position::Position;
use crate::model::timed::SpeedTarget;
use crate::world::geometry::Motion;
use crate::world::motion::{Course, LateralShape, Pace, Part, Path};
use crate::world::profile::Profile;
use crate::world::shape::{SHORTEST_S, SpeedShape, seconds};
use crate::world::{World, WorldError};

impl World {
    /// Places the entities of Init's teleports, each after the one that it is placed from.
    pub(super) fn place(&mut self) -> Result<(), WorldError> {
        let script = Arc::clone(&self.script);
        let places = script.init.iter().filter_map(|item| match (&item.action, item.actor) {
            (Action::Teleport(position), Some(actor)) => Some((actor, position)),
            (Action::Add { entity, position }, _) => Some((*entity, position)),
            _ => None,
        });
        let circle = "cannot be placed: the entities that it is placed from depend on each other";
        let placed = self.in_order(places.collect(), |position| position.entity(), circle)?;
        for (actor, position) in placed {
            let Some(at) = self.resolve(position) else {
                let reason =
                    "cannot be placed: the lane or the entity that it is placed from is not there";
                return Err(self.no_start(actor, reason));
            };
            self.fits_its_lane(actor, &at)?;
            self.state.movers[actor].motion = at;
        }
        Ok(())
    }

    /// Sets the speeds that Init sets at once, each after the one that it depends on.
    pub(super) fn first_speeds(&mut self) -> Result<(), WorldError> {
        let script = Arc::clone(&self.script);
        let speeds = script.init.iter().filter_map(|item| match &item.action {
            Action::Speed { target, transition } if target.is_at_once(transition) => {
                Some((item.actor?, target))
            }
            _ => None,
        });
        let circle = "has a speed at the start that depends on itself";
        for (actor, target) in self.in_order(speeds.collect(), |target| target.entity(), circle)? {
            self.state.movers[actor].motion.speed_mps = self.target_speed(target);
        }
        Ok(())
    }

    /// Entities with what they wait for, each after the entity that it waits for. `circle` is wrong with one that waits
    /// for itself.
    fn in_order<T>(
        &self,
        mut open: Vec<(usize, T)>,
        waits_for: impl Fn(&T) -> Option<usize>,
        circle: &str,
    ) -> Result<Vec<(usize, T)>, WorldError> {
        let mut done = Vec::with_capacity(open.len());
        while !open.is_empty() {
            let is_open = |other: usize| open.iter().any(|(actor, _)| *actor == other);
            let next = open.iter().position(|(_, it)| !waits_for(it).is_some_and(is_open));
            done.push(open.remove(next.ok_or_else(|| self.no_start(open[0].0, circle))?));
        }
        Ok(done)
    }

    /// Checks that a vehicle that is placed on a lane is not wider than that.
    fn fits_its_lane(&self, actor: usize, at: &Motion) -> Result<(), WorldError> {
        let (road, entity) = (&self.script.roads[at.row], &self.script.entities[actor]);
        let width_m = entity.body.width_m;
        let lane = road.lane_at(at.s_m, at.t_m).filter(|_| road.holds(at.s_m, at.t_m));
        match lane.filter(|lane| lane.width_m < width_m && entity.category == Category::Vehicle) {
            None => Ok(()),
            Some(lane) => {
                let expected = format!("at most the {} m of lane {}", lane.width_m, lane.id);
                Err(self.no_start(actor, &format!("is {width_m} m wide, expected {expected}")))
            }
        }
    }

    fn no_start(&self, actor: usize, reason: &str) -> WorldError {
        let entity = self.script.entities[actor].name.clone();
        WorldError::Start { entity, reason: reason.to_owned() }
    }

    /// Begins an action for its actors. `element` is the storyboard's action that it belongs to.
    pub(super) fn start(&mut self, action: &Action, actors: &[usize], element: Option<usize>) {
        let before = self.count(element);
        match action {
            Action::Set { value, change } => self.change(*value, change),
            Action::Add { entity, position } => self.teleport(*entity, position),
            Action::Delete { entity } => self.delete(*entity),
            Action::Nothing => {}
            Action::Cycle(cycle) => self.begin_cycle(cycle),
            Action::Phase { controller, phase } => self.begin_phase(*controller, *phase),
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
            Action::Route(places) => {
                let row = places.first().and_then(|place| self.resolve(place)).map(|at| at.row);
                let there = row.and_then(|row| self.on_row(&self.motion(actor), row));
                if let Some(motion) = there.filter(|_| !self.is_external(actor)) {
                    self.state.movers[actor].motion = motion;
                }
            }
            Action::Speed { target, transition } => {
                self.begin_speed(actor, target, transition, element)
            }
            Action::Distance(distance) => {
                if distance.limits.is_none() && !distance.continuous {
                    self.clear(actor, Part::Pace);
                    if let Some(goal) = self.gap_goal(actor, distance)
                        && !self.is_external(actor)
                    {
                        self.state.movers[actor].motion.s_m = goal;
                    }
                } else {
                    self.set_pace(actor, Pace::Keep(*distance), element);
                }
            }
            Action::Profile(profile) if profile.relative_to != Some(actor) => {
                let of_other = profile.relative_to.map_or(0.0, |it| self.motion(it).speed_mps);
                let from_mps = self.motion(actor).speed_mps - of_other;
                let profile = Profile::of(profile, from_mps, self.state.time_ns);
                self.set_pace(actor, Pace::Profile(profile), element);
            }
            Action::Meet(meeting) if self.can_meet(actor, meeting) => {
                self.set_pace(actor, Pace::Meet(meeting.clone()), element);
            }
            Action::LaneChange { target, offset_m, transition } => {
                let Some(lane_t_m) = self.lane_goal(actor, target) else { return };
                let lane_t_m = self.take_row_of(actor, lane_t_m);
                let (from_t_m, to_t_m) = (self.motion(actor).t_m, lane_t_m + offset_m);
                let duration_s = transition.duration_s((to_t_m - from_t_m).abs(), 1.0);
                let by = match transition.dimension {
                    Dimension::Distance if duration_s > 0.0 => Course::Way {
                        start_m: self.state.movers[actor].odometer_m,
                        length_m: transition.value,
                    },
                    _ => Course::Time { start_ns: self.state.time_ns, duration_s },
                };
                let shape = transition.shape;
                let shape = LateralShape { from_t_m, to_t_m, by, shape, endless: None };
                self.set_steer(actor, shape, element);
            }
            Action::LaneOffset { target, shape, max_lateral_mps2, continuous } => {
                let own = self.motion(actor);
                let other = |entity: usize| self.on_row(&self.motion(entity), own.row);
                let (to_t_m, follow, most_mps) = match *target {
                    OffsetTarget::Lane(offset_m) => {
                        let lane = self.script.roads[own.row].lane_at(own.s_m, own.t_m);
                        (lane.map_or(0.0, |lane| lane.center_m) + offset_m, None, f64::INFINITY)
                    }
                    OffsetTarget::Entity { entity, offset_m } => {
                        let Some(other) = other(entity) else { return };
                        (other.t_m + offset_m, Some((entity, offset_m)), f64::INFINITY)
                    }
                    OffsetTarget::Aside(aside) => {
                        let Some(other) = other(aside.entity) else { return };
                        let offset_m = self.offset_aside(actor, &other, &aside);
                        (other.t_m + offset_m, Some((aside.entity, offset_m)), aside.most_mps)
                    }
                };
                let (from_t_m, way_m) = (own.t_m, (to_t_m - own.t_m).abs());
                let duration_s = match max_lateral_mps2 {
                    Some(most) if *shape != Shape::Step => {
                        libm::sqrt(way_m * shape.largest_curvature() / most)
                    }
                    _ => 0.0,
                };
                let duration_s = duration_s.max(way_m * shape.largest_rate() / most_mps);
                let by = Course::Time { start_ns: self.state.time_ns, duration_s };
                let endless = continuous.then_some(follow);
                let shape = LateralShape { from_t_m, to_t_m, by, shape: *shape, endless };
                self.set_steer(actor, shape, element);
            }
            Action::Trajectory(trajectory) => self.begin_path(actor, trajectory, element),
            // A profile that depends on itself is done at once, and so are the world's actions.
            _ => {}
        }
    }

    /// Puts an entity on a row of roads on which the lane at `t_m` leads on, if its own row leaves that lane. Returns
    /// the lateral position of the lane there.
    fn take_row_of(&mut self, actor: usize, t_m: f64) -> f64 {
        let own = self.motion(actor);
        let through = |row: &usize| !self.script.roads[*row].cuts.is_empty();
        let others = (0..self.script.roads.len()).filter(through);
        let rows = std::iter::once(own.row).chain(others);
        let mut lanes = rows.filter_map(|row| self.on_row(&Motion { t_m, ..own }, row));
        let leads =
            |at: &Motion| self.script.roads[at.row].leads_on(at.s_m, at.t_m, at.direction());
        let lane = lanes.find(leads);
        let Some(lane) = lane.filter(|_| !self.is_external(actor)) else { return t_m };
        if let Some(there) = self.on_row(&own, lane.row) {
            self.state.movers[actor].motion = there;
        }
        lane.t_m
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
            SpeedTarget::Relative { entity, factor, offset_mps, continuous: true } => {
                (entity, factor, offset_mps)
            }
            _ => {
                // All shapes are symmetric: the mean speed is the mean of both ends.
                let mean_mps = 0.5 * (from_mps + to_mps);
                let duration_s = transition.duration_s((to_mps - from_mps).abs(), mean_mps);
                if duration_s < SHORTEST_S {
                    self.clear(actor, Part::Pace);
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

    fn begin_path(&mut self, actor: usize, trajectory: &Trajectory, element: Option<usize>) {
        let start_s = seconds(self.state.time_ns);
        let mut corners = Vec::with_capacity(trajectory.vertices.len());
        let mut way_m = -trajectory.initial_offset_m;
        for vertex in &trajectory.vertices {
            let Some(place) = self.resolve(&vertex.position) else { continue };
            let Pose { x_m, y_m, .. } = self.pose(&place);
            let at = match &trajectory.timing {
                Some(timing) => {
                    let base = if timing.absolute { 0.0 } else { start_s };
                    base + timing.scale * vertex.time_s + timing.offset_s
                }
                None => {
                    if let Some(&(_, x, y)) = corners.last() {
                        way_m += libm::hypot(x_m - x, y_m - y);
                    }
                    way_m
                }
            };
            if corners.last().is_none_or(|&(last, _, _): &(f64, f64, f64)| last < at) {
                corners.push((at, x_m, y_m));
            }
        }
        if corners.len() < 2 {
            return;
        }
        let timed = trajectory.timing.is_some();
        if timed {
            self.clear(actor, Part::Pace);
        }
        self.clear(actor, Part::Steer);
        self.clear(actor, Part::Path);
        let by_way_from_m = (!timed).then_some(self.state.movers[actor].odometer_m);
        let mover = &mut self.state.movers[actor];
        mover.path = Some(Path { corners, by_way_from_m });
        mover.owners[Part::Path as usize] = element;
        self.hold(element);
    }

    /// The offset from the lateral position of another entity at which one is at its distance beside that, m.
    fn offset_aside(&self, actor: usize, other: &Motion, aside: &Aside) -> f64 {
        let [own_m, other_m] =
            [actor, aside.entity].map(|it| self.script.entities[it].body.width_m);
        let bodies_m = if aside.freespace { 0.5 * (own_m + other_m) } else { 0.0 };
        let left_m = (self.motion(actor).t_m - other.t_m) * other.direction();
        let kept_m = (left_m.abs() - bodies_m).max(0.0);
        let apart_m = other.direction() * (aside.distance_m.unwrap_or(kept_m) + bodies_m);
        match aside.side {
            LateralSide::Left => apart_m,
            LateralSide::Any if left_m >= 0.0 => apart_m,
            LateralSide::Any | LateralSide::Right => -apart_m,
        }
    }

    /// The distance between two places in the plane, m.
    pub(super) fn apart(&self, from: &Motion, to: &Motion) -> f64 {
        let [from, to] = [from, to].map(|at| self.pose(at));
        libm::hypot(to.x_m - from.x_m, to.y_m - from.y_m)
    }

    fn set_pace(&mut self, actor: usize, pace: Pace, element: Option<usize>) {
        self.clear(actor, Part::Pace);
        let mover = &mut self.state.movers[actor];
        mover.pace = pace;
        mover.owners[Part::Pace as usize] = element;
        self.hold(element);
    }

    fn set_steer(&mut self, actor: usize, shape: LateralShape, element: Option<usize>) {
        let immediate = matches!(shape.by, Course::Time { duration_s, .. } if duration_s <= 0.0);
        self.clear(actor, Part::Steer);
        self.clear(actor, Part::Path);
        if immediate && !self.is_external(actor) {
            self.state.movers[actor].motion.t_m = shape.to_t_m;
        }
        if immediate && shape.endless.is_none() {
            return;
        }
        let mover = &mut self.state.movers[actor];
        mover.steer = Some(shape);
        mover.owners[Part::Steer as usize] = element;
        self.hold(element);
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
        if let Some(at) = self.resolve(position) {
            let motion = &mut self.state.movers[actor].motion;
            let Motion { speed_mps, lateral_mps, acceleration_mps2, .. } = *motion;
            *motion = Motion { speed_mps, lateral_mps, acceleration_mps2, ..at };
        }
    }

    fn delete(&mut self, entity: usize) {
        if !self.is_external(entity) {
            for part in [Part::Pace, Part::Steer, Part::Path] {
                self.clear(entity, part);
            }
            self.state.movers[entity].motion = Motion::default();
        }
    }
}
