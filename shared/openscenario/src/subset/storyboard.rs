//! The storyboard: Init, stories, acts, groups, maneuvers, events.

use super::action::{GlobalAction, PrivateAction};
use super::catalog::FromCatalog;
use super::condition::{StartTrigger, StopTrigger};
use super::entity::EntityRef;
use super::reference::EntityName;
use super::unused::UserDefinedAction;
use crate::declare::{AtLeastOne, Count, Node, OneOf, Placed, Text, Truth, elements};
use crate::error::{Place, ReadError};
use crate::model::condition::Trigger;
use crate::model::storyboard::{NamedAction, Priority};
use crate::model::timed::SpeedTarget;
use crate::model::{InitAction, action, storyboard};
use crate::parameter::{ParameterDeclarations, Scoped};

elements! { "Storyboard";
    /// ends the run when its stop trigger fires; otherwise the run ends at its duration
    Storyboard -> (Vec<storyboard::Story>, Option<Trigger>) []
    {_: Init, stories: Vec<Scoped<Story>>, stop: Option<Placed<StopTrigger>>}
    |node| {
        let named = |(i, (name, acts)): (usize, (Option<String>, _))| {
            let name = name.unwrap_or_else(|| format!("story {}", i + 1));
            storyboard::Story { name, acts }
        };
        let stories = stories.into_iter().enumerate().map(named).collect();
        let (place, stop) = stop.unzip();
        node.scene.spots.borrow_mut().stop = place.map(|place| place.spot);
        Ok((stories, stop))
    }

    /// done before the first step: teleports, then speeds, then the rest
    Init -> () [] {_: Actions}
    |node| {
        let mut init = node.scene.init.borrow_mut();
        require_places(node, &init)?;
        init.sort_by_key(|item| match item.action {
            action::Action::Add { .. } | action::Action::Teleport(_) => 0,
            action::Action::Speed { .. } => 1,
            _ => 2,
        });
        Ok(())
    }

    /// actions of Init
    Actions -> () [] {global: Vec<GlobalAction>, _: Vec<UserDefinedAction>, private: Vec<Private>}
    |node| {
        let mut init = node.scene.init.borrow_mut();
        init.extend(global.into_iter().map(|action| InitAction { actor: None, action }));
        init.extend(private.into_iter().flatten());
        Ok(())
    }

    /// actions of one entity
    Private -> Vec<InitAction> ["entityRef" actor: EntityName]
    {placed: AtLeastOne<Placed<PrivateAction>>}
    |node| {
        let (mut actions, mut route) = (Vec::new(), None);
        for (place, action) in placed {
            if let action::Action::Route(over) = action {
                route = Some((place, over));
                continue;
            }
            not_itself(node, &place, &[actor], &action)?;
            let is_done = match &action {
                _ if actor != node.scene.ego.get() => true,
                action::Action::Teleport(_) | action::Action::Nothing => true,
                action::Action::Speed { transition, .. } if transition.is_immediate() => true,
                // The ego's stack reaches this speed in its own time.
                action::Action::Speed { target: SpeedTarget::Absolute(mps), .. } => {
                    node.scene.ego_goal_mps.set(Some(*mps));
                    node.scene.notice(format!(
                        "{place}: the ego begins with its speed before this action, and {mps} m/s is its set speed"
                    ));
                    false
                }
                _ => {
                    let reason = "timegap's stack drives the ego from the start";
                    let expected =
                        "in Init a teleport, an absolute speed, a route or a controller action for it";
                    return Err(ReadError::meaning(place, reason, expected));
                }
            };
            if is_done {
                actions.push(InitAction { actor: Some(actor), action });
            }
        }
        let (place, over) = route.unwrap_or_else(|| (node.place(), Vec::new()));
        for InitAction { action, .. } in &mut actions {
            if let action::Action::Teleport(position) = action {
                *position = node.scene.on_its_way(&place, *position, &over)?;
            }
        }
        node.scene.spots.borrow_mut().starts[actor] = node.place().spot;
        Ok(actions)
    }

    /// runs from the start
    Story -> (Option<String>, Vec<storyboard::Act>) ["name" name: Option<Text>]
    {_: Option<ParameterDeclarations>, acts: AtLeastOne<Act>}
    { Ok((name, acts)) }

    /// without a start trigger, or with an empty one, it starts with its story
    Act -> storyboard::Act ["name" name: Text]
    {groups: AtLeastOne<ManeuverGroup>, start: Option<StartTrigger>, stop: Option<StopTrigger>}
    |node| {
        let start = not_empty(node, start);
        Ok(storyboard::Act { name, start, stop, groups })
    }

    /// runs again until its count is reached
    ManeuverGroup -> storyboard::ManeuverGroup
    ["maximumExecutionCount" executions: Count, "name" name: Text]
    {actors: Actors, maneuvers: Vec<OneOf<(FromCatalog<Maneuver>, Scoped<Maneuver>)>>}
    { Ok(storyboard::ManeuverGroup { name, executions, actors, maneuvers }) }

    /// selectTriggeringEntities="false" only
    Actors -> Vec<usize> ["selectTriggeringEntities" by_trigger: Truth] {actors: Vec<EntityRef>}
    |node| {
        if by_trigger {
            let reason = "actors chosen by their triggers are not supported";
            return Err(node.wrong("selectTriggeringEntities", reason, "false"));
        }
        let actors = actors.concat();
        node.scene.actors.replace(actors.clone());
        Ok(actors)
    }

    /// its events stand by while it runs
    Maneuver -> storyboard::Maneuver ["name" name: Text]
    {_: Option<ParameterDeclarations>, events: AtLeastOne<Event>}
    { Ok(storyboard::Maneuver { name, events }) }

    /// overwrite and override end other events of the maneuver; without a start trigger, or with an empty one, it
    /// starts with its maneuver
    Event -> storyboard::Event
    ["name" name: Text, "priority" priority: Priority,
        "maximumExecutionCount" executions: Option<Count>]
    {actions: AtLeastOne<Action>, start: Option<StartTrigger>}
    |node| {
        let (executions, start) = (executions.unwrap_or(1), not_empty(node, start));
        Ok(storyboard::Event { name, priority, executions, start, actions })
    }

    /// done for every actor of the group
    Action -> NamedAction ["name" name: Text]
    {action: OneOf<(PrivateAction, GlobalAction, UserDefinedAction)>}
    |node| {
        let private = node.children().find(|child| child.name() == PrivateAction::NAME);
        private.map_or(Ok(()), |private| check_of_actors(private, &action))?;
        Ok(NamedAction { name, action })
    }
}

/// A start trigger without conditions is none: their authors mean "at once".
fn not_empty(node: Node<'_>, start: Option<Trigger>) -> Option<Trigger> {
    start.filter(|trigger| {
        let is_empty = trigger.0.is_empty();
        if is_empty {
            let place = node.place();
            node.scene
                .notice(format!("{place}: its start trigger is empty, and it starts at once"));
        }
        !is_empty
    })
}

fn check_of_actors(node: Node<'_>, action: &action::Action) -> Result<(), ReadError> {
    let (scene, actors) = (node.scene, node.scene.actors.borrow());
    if actors.is_empty() {
        return Err(node.refuse("the group has no actor for it", "an `EntityRef`"));
    }
    not_itself(node, &node.place(), &actors, action)?;
    if actors.contains(&scene.ego.get()) && *action != action::Action::Nothing {
        let text = "actions of the ego take their time in the storyboard and do not move it: timegap's stack drives it";
        scene.notice(text.to_owned());
    }
    Ok(())
}

/// Checks that no actor depends on its own motion.
fn not_itself(
    node: Node<'_>,
    place: &Place,
    actors: &[usize],
    action: &action::Action,
) -> Result<(), ReadError> {
    let Some(entity) = action.follows().filter(|entity| actors.contains(entity)) else {
        return Ok(());
    };
    let reason = format!("`{}` would follow itself", node.scene.entities.borrow()[entity].name);
    Err(ReadError::meaning(place.clone(), reason, "another entity"))
}

/// Checks that the ego has a place in Init, and notes the others without one.
fn require_places(node: Node<'_>, init: &[InitAction]) -> Result<(), ReadError> {
    let is_placed = |entity: usize| {
        init.iter().any(|item| match item.action {
            action::Action::Teleport(_) => item.actor == Some(entity),
            action::Action::Add { entity: added, .. } => added == entity,
            _ => false,
        })
    };
    let entities = node.scene.entities.borrow();
    for (index, entity) in entities.iter().enumerate().filter(|(index, _)| !is_placed(*index)) {
        let name = &entity.name;
        if index == node.scene.ego.get() {
            let reason = format!("the ego `{name}` is not placed");
            return Err(node.refuse(reason, "a `TeleportAction` for it"));
        }
        node.scene.notice(format!(
            "`{name}` has no place in Init: it is not on the road until it is added or teleported"
        ));
    }
    Ok(())
}
