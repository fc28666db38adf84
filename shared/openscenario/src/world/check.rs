//! Checks that the actions of a script refer to entities and values that it has.

use crate::model::action::{Action, LaneTarget, OffsetTarget, SpeedTarget};
use crate::model::position::Position;
use crate::model::{Category, MAX_ENTITIES, Script};
use crate::world::WorldError;
use crate::world::targets::reference;

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
        Action::Profile(profile) => {
            profile.relative_to.map_or(Ok(()), |entity| index("entity", entity, entities))
        }
        Action::Meet(meeting) => {
            index("entity", meeting.master, entities)?;
            at(&meeting.goal)?;
            at(&meeting.master_goal)
        }
        Action::Teleport(position) => at(position),
        Action::Add { entity, position } => {
            index("entity", *entity, entities)?;
            at(position)
        }
        Action::Trajectory(line) => {
            line.vertices.iter().try_for_each(|vertex| at(&vertex.position))
        }
        Action::Set { value, .. } | Action::Phase { controller: value, .. } => {
            index("value", *value, script.values.len())
        }
        Action::Cycle(cycle) => {
            let signals = cycle.phases.iter().flat_map(|phase| &phase.states);
            std::iter::once(cycle.controller)
                .chain(signals.map(|(signal, _)| *signal))
                .try_for_each(|value| index("value", value, script.values.len()))
        }
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

/// Checks that a vehicle that is placed on a lane is not wider than that.
pub(super) fn fits_its_lane(
    script: &Script,
    actor: usize,
    s_m: f64,
    t_m: f64,
) -> Result<(), WorldError> {
    let (entity, road) = (&script.entities[actor], &script.road);
    let width_m = entity.body.width_m;
    let Some(lane) = road.lane_at(s_m, t_m).filter(|_| road.holds(s_m, t_m)) else {
        return Ok(());
    };
    if entity.category == Category::Vehicle && width_m > lane.width_m {
        let (entity, lane_m) = (entity.name.clone(), lane.width_m);
        return Err(WorldError::Width { entity, width_m, lane: lane.id, lane_m });
    }
    Ok(())
}
