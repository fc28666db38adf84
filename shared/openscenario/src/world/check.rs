//! Checks that a script refers to entities and values that it has.

use crate::model::action::{Action, Aside, LaneTarget, OffsetTarget};
use crate::model::condition::{CollisionWith, EntityTest, Measured, Target, Test};
use crate::model::position::Position;
use crate::model::{MAX_ENTITIES, Script};
use crate::world::WorldError;
use crate::world::plan::Plan;

/// Checks that every index of a script is inside its list.
pub(super) fn check(script: &Script, plan: &Plan) -> Result<(), WorldError> {
    let (entities, values) = (script.entities.len(), script.values.len());
    inside("entity", script.ego, entities)?;
    inside("number of entities", entities, MAX_ENTITIES + 1)?;
    let actors = script.init.iter().filter_map(|item| item.actor);
    let actors = actors.chain(plan.elements.iter().flat_map(|element| element.actors.clone()));
    let done = script.init.iter().map(|item| &item.action);
    let done = done.chain(plan.elements.iter().filter_map(|element| element.action.as_ref()));
    let acts = plan.elements.iter().flat_map(|element| [&element.start, &element.stop]);
    let triggers = acts.chain([&plan.stop]).filter_map(|numbered| numbered.trigger.as_ref());
    let conditions = triggers.flat_map(|trigger| trigger.0.iter().flatten());
    let known = done.map(of_action).chain(conditions.map(|condition| of_test(&condition.test)));
    let known: Vec<Indices> = known.chain([(actors.collect(), Vec::new())]).collect();
    known.iter().try_for_each(|(of_entities, of_values)| {
        of_entities.iter().try_for_each(|&index| inside("entity", index, entities))?;
        of_values.iter().try_for_each(|&index| inside("value", index, values))
    })
}

/// Places in the lists of entities and of values.
type Indices = (Vec<usize>, Vec<usize>);

fn of_action(action: &Action) -> Indices {
    let entities = match action {
        Action::Speed { target, .. } => vec![target.entity()],
        Action::LaneChange { target: LaneTarget::Beside { entity, .. }, .. }
        | Action::LaneOffset { target: OffsetTarget::Entity { entity, .. }, .. }
        | Action::LaneOffset { target: OffsetTarget::Aside(Aside { entity, .. }), .. }
        | Action::Delete { entity } => vec![Some(*entity)],
        Action::Distance(distance) => vec![Some(distance.entity)],
        Action::Profile(profile) => vec![profile.relative_to],
        Action::Meet(meeting) => {
            vec![Some(meeting.master), meeting.goal.entity(), meeting.master_goal.entity()]
        }
        Action::Teleport(position) => vec![position.entity()],
        Action::Route(places) => places.iter().map(Position::entity).collect(),
        Action::Add { entity, position } => vec![Some(*entity), position.entity()],
        Action::Trajectory(line) => {
            line.vertices.iter().map(|vertex| vertex.position.entity()).collect()
        }
        Action::Set { value, .. } | Action::Phase { controller: value, .. } => {
            return (Vec::new(), vec![*value]);
        }
        Action::Cycle(cycle) => {
            let signals = cycle.phases.iter().flat_map(|phase| &phase.states);
            let signals = signals.map(|(signal, _)| *signal).chain([cycle.controller]);
            return (Vec::new(), signals.collect());
        }
        Action::LaneChange { .. } | Action::LaneOffset { .. } | Action::Nothing => Vec::new(),
    };
    (entities.into_iter().flatten().collect(), Vec::new())
}

fn of_test(test: &Test) -> Indices {
    let (entities, is) = match test {
        Test::Entity { entities, is, .. } => (entities, is),
        Test::Value { of, .. } => return (Vec::new(), vec![*of]),
        Test::Time { .. } | Test::Element { .. } => return Indices::default(),
    };
    let other = match is {
        EntityTest::Collision(CollisionWith::Entity(entity))
        | EntityTest::RelativeSpeed { entity, .. } => Some(*entity),
        EntityTest::ReachPosition { position, .. } => position.entity(),
        EntityTest::Distance { to: Measured { target, .. }, .. }
        | EntityTest::Headway { to: Measured { target, .. }, .. }
        | EntityTest::TimeToCollision { to: Measured { target, .. }, .. } => match target {
            Target::Entity(entity) => Some(*entity),
            Target::Position(position) => position.entity(),
        },
        _ => None,
    };
    let cleared = if let EntityTest::Clearance(of) = is { &of.entities[..] } else { &[] };
    (entities.iter().chain(cleared).copied().chain(other).collect(), Vec::new())
}

fn inside(what: &'static str, index: usize, count: usize) -> Result<(), WorldError> {
    if index < count { Ok(()) } else { Err(WorldError::Index { what, index, count }) }
}
