//! The moving world: a [`Script`] stepped in time.
//!
//! No clock, no files, no random numbers: the same calls give the same motion, bit by bit. A step moves the entities to
//! the new time, ends actions, evaluates triggers, starts actions. Speeds and lateral positions of shapes are closed
//! forms of time. So is the distance covered under a shape. The size of the steps decides only when triggers are
//! evaluated.

mod bend;
mod check;
mod condition;
mod distance;
mod geometry;
mod meeting;
mod motion;
mod plan;
mod profile;
mod shape;
mod signals;
mod start;
mod storyboard;
mod targets;

use std::sync::Arc;

use road::{Leg, Pose};
use serde::{Deserialize, Serialize};

use crate::expression::Value;
use crate::model::action::Action;
use crate::model::condition::{EntityTest, Test};
use crate::model::{Drive, Script};
use crate::road::{Ground, Road};
pub use bend::Way;
use condition::ConditionMemory;
pub use geometry::{Extent, Motion};
use motion::Mover;
pub use plan::NotFound;
use plan::Plan;
use signals::Cycle;
use storyboard::Progress;

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    #[error("{what} {index} does not exist, expected less than {count}")]
    Index { what: &'static str, index: usize, count: usize },
    #[error("the road: {0}")]
    Road(#[from] road::AxisError),
    #[error(
        "the lanes of the road do not fit together, expected sections in order whose links lead to lanes"
    )]
    Lanes,
    /// A condition names a part of the storyboard that is not there.
    #[error("{0}")]
    Element(#[from] NotFound),
    #[error("`{entity}` {reason}")]
    Start { entity: String, reason: String },
}

impl WorldError {
    /// The entity that the error is about.
    pub fn entity(&self) -> Option<&str> {
        match self {
            Self::Start { entity, .. } => Some(entity),
            _ => None,
        }
    }
}

/// The state of a world. A world of the same script that is restored from it moves on in the same way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    time_ns: u64,
    step: u64,
    stopped: bool,
    /// The ego came to the end of its road or lane, and the drive ends there.
    road_ended: bool,
    was_on_road: bool,
    /// The ego was on a lane for vehicles.
    #[serde(default)]
    was_on_lane: bool,
    /// A part of the storyboard has changed since this was cleared.
    changed: bool,
    movers: Vec<Mover>,
    progress: Vec<Progress>,
    conditions: Vec<ConditionMemory>,
    values: Vec<Value>,
    cycles: Vec<Cycle>,
}

/// A script that moves.
///
/// The caller moves the ego: it gives the ego's motion before each step.
///
/// ```
/// use openscenario::model::{Body, Category, Drive, Entity, InitAction, Script};
/// use openscenario::model::action::Action;
/// use openscenario::model::position::{From, Heading, Position};
/// use openscenario::{World, road::Road};
///
/// let body = Body { center_ahead_m: 1.4, center_left_m: 0.0, length_m: 4.5, width_m: 1.8 };
/// let ego = Entity {
///     name: "Ego".to_owned(),
///     category: Category::Vehicle,
///     body,
///     drive: Drive::External,
/// };
/// let from = From::Road { row: 0, s_m: 10.0, t_m: -1.75 };
/// let place = Action::Teleport(Position { from, heading: Heading::Road(0.0) });
/// let mut world = World::new(Script {
///     roads: vec![Road::assumed()],
///     ego: 0,
///     entities: vec![ego],
///     values: Vec::new(),
///     init: vec![InitAction { actor: Some(0), action: place }],
///     stories: Vec::new(),
///     stop: None,
/// })?;
/// let mut motion = world.motion(0);
/// motion.s_m += 0.5;
/// world.observe(0, motion);
/// world.step(10_000_000);
/// assert_eq!(world.motion(0).s_m, 10.5);
/// # Ok::<(), openscenario::WorldError>(())
/// ```
#[derive(Clone, Debug)]
pub struct World {
    script: Arc<Script>,
    /// The rows of roads in the plane.
    grounds: Arc<Vec<Ground>>,
    /// The lanes are the same all along.
    is_uniform: bool,
    plan: Arc<Plan>,
    state: State,
}

impl World {
    /// The world at its start, after Init.
    ///
    /// # Errors
    /// When the script refers to an entity or a value that it lacks, or an entity cannot be placed.
    pub fn new(script: Script) -> Result<Self, WorldError> {
        let plan = Plan::of(&script)?;
        let state = State {
            movers: vec![Mover::default(); script.entities.len()],
            progress: vec![Progress::default(); plan.elements.len()],
            conditions: vec![ConditionMemory::default(); plan.conditions],
            values: script.values.iter().map(|named| named.value.clone()).collect(),
            ..State::default()
        };
        let is_sound = |road: &Road| !road.parts.is_empty() && road.lanes.is_sound();
        if script.roads.is_empty() || !script.roads.iter().all(is_sound) {
            return Err(WorldError::Lanes);
        }
        let plane = script.roads[0].start();
        let grounds = script.roads.iter().map(|road| Ground::of(road, &plane));
        let grounds = Arc::new(grounds.collect::<Result<Vec<_>, _>>()?);
        let is_uniform = script.roads.iter().all(|road| road.lanes.is_uniform());
        let (script, plan) = (Arc::new(script), Arc::new(plan));
        let mut world = Self { script, grounds, is_uniform, plan, state };
        world.place()?;
        world.first_speeds()?;
        let script = Arc::clone(&world.script);
        for item in &script.init {
            let actors = item.actor.as_slice();
            match item.action {
                Action::Teleport(_) | Action::Add { .. } => {}
                Action::Speed { transition, target } if target.is_at_once(&transition) => {}
                ref action => world.start(action, actors, None),
            }
        }
        Ok(world)
    }

    /// Sets the motion of an entity that the caller moves, for the next step.
    pub fn observe(&mut self, entity: usize, motion: Motion) {
        if let Some(mover) = self.state.movers.get_mut(entity) {
            mover.observed = Some(motion);
        }
    }

    /// Moves the world to `time_ns` since the start. Time never goes back.
    pub fn step(&mut self, time_ns: u64) {
        let time_ns = time_ns.max(self.state.time_ns);
        self.state.step += 1;
        self.advance(time_ns);
        let (on_road, on_lane) = self.where_ego_is();
        let has_left = self.state.was_on_road && !on_road || self.state.was_on_lane && !on_lane;
        if has_left && !self.state.stopped && !self.awaits_road_end() {
            (self.state.road_ended, self.state.stopped) = (true, true);
        }
        self.state.was_on_road |= on_road;
        self.state.was_on_lane |= on_lane;
        self.state.time_ns = time_ns;
        if !self.state.stopped {
            self.signals();
            self.storyboard();
        }
    }

    /// Continues from the state of another world of the same script. The state of another script is ignored.
    pub fn restore(&mut self, state: State) {
        let alike = state.movers.len() == self.state.movers.len()
            && state.progress.len() == self.state.progress.len()
            && state.conditions.len() == self.state.conditions.len()
            && state.values.len() == self.state.values.len();
        if alike {
            self.state = state;
        }
    }

    /// The state, for [`World::restore`].
    pub fn state(&self) -> &State {
        &self.state
    }

    pub fn script(&self) -> &Script {
        &self.script
    }

    pub fn motion(&self, entity: usize) -> Motion {
        self.state.movers[entity].motion
    }

    /// All that happens is on one straight row of roads.
    pub fn is_straight(&self) -> bool {
        let is_line = |leg: &Leg| leg.axis.is_straight() && leg.start == Pose::default();
        self.grounds.iter().all(|ground| ground.legs.len() == 1 && is_line(&ground.legs[0]))
    }

    /// The extent of an entity's body on the road.
    pub fn extent(&self, entity: usize) -> Extent {
        Extent::of(&self.script.entities[entity].body, &self.motion(entity))
    }

    /// The drive has come to its end: the stop trigger has fired, or the ego's road has ended.
    pub fn is_stopped(&self) -> bool {
        self.state.stopped
    }

    /// The ego's front came to the end of its road, or of its lane. The part beyond is in no file.
    pub fn has_road_ended(&self) -> bool {
        self.state.road_ended
    }

    /// The stop trigger waits for an end of the road itself.
    fn awaits_road_end(&self) -> bool {
        let is_end =
            |test: &Test| matches!(test, Test::Entity { is: EntityTest::EndOfRoad(_), .. });
        let groups = self.script.stop.iter().flat_map(|trigger| &trigger.0);
        groups.flatten().any(|condition| is_end(&condition.test))
    }

    /// True if the ego's front is between the road's ends, and true if it is on a lane for vehicles. An assumed road has
    /// no ends.
    fn where_ego_is(&self) -> (bool, bool) {
        let ego = self.motion(self.script.ego);
        let road = &self.script.roads[ego.row];
        let Some(length_m) = road.length_m else { return (true, true) };
        let front_m = self.extent(self.script.ego).front_s_m(ego.direction());
        let lanes = road.lanes.strips(front_m).filter(|lane| lane.drivable);
        let mut apart_m = lanes.map(|lane| (ego.t_m - lane.center_m).abs() - 0.5 * lane.width_m);
        let on_road = ego.present && (0.0..=length_m).contains(&front_m);
        (on_road, on_road && apart_m.any(|apart_m| apart_m <= 0.0))
    }

    fn is_external(&self, entity: usize) -> bool {
        self.script.entities[entity].drive == Drive::External
    }
}
