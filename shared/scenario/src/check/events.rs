//! Checks of the events of actors: they hold together.

use crate::actor::{Actor, Profile};
use crate::event::{ActorEvent, MAX_EVENTS, When};
use crate::name::Name;
use crate::reading::refuse;
use crate::{Problem, accepted};

pub(super) fn check(actors: &[Actor]) -> Result<(), Problem> {
    for (i, actor) in actors.iter().enumerate().filter(|(_, actor)| !actor.events.is_empty()) {
        let is_plain = actor.profile == Profile::Constant
            && actor.lateral.is_empty()
            && actor.appears_at_s.value() == 0.0
            && actor.leaves_at_s.is_none()
            && actor.max_speed_mps.is_none();
        refuse!(if !is_plain, "actors.{i}.events":
            "an actor with events is on the road from start to end and moves by them alone",
            "no profile, lateral, appears_at_s, leaves_at_s or max_speed_mps beside events");
        refuse!(if actor.events.len() > MAX_EVENTS,
            "actors.{i}.events": "too many events", "at most {MAX_EVENTS}");
        for (k, event) in actor.events.iter().enumerate() {
            one(actors, actor, &format!("actors.{i}.events.{k}"), event)?;
        }
    }
    Ok(())
}

fn one(actors: &[Actor], own: &Actor, path: &str, event: &ActorEvent) -> Result<(), Problem> {
    refuse!(if event.speed.is_none() && event.lateral.is_none(),
        "{path}": "an event that does nothing", "`speed`, `lateral` or both");
    let names = || own.events.iter().filter_map(|other| other.name.as_ref()).map(Name::as_str);
    let named = |name: &Name| names().filter(|other| *other == name.as_str()).count();
    refuse!(if event.name.as_ref().is_some_and(|name| named(name) > 1), "{path}.name":
        "another event of this actor has the same name", "a name of its own");
    if let When::Completed(name) = &event.when {
        let (awaited, known) = (name.as_str(), accepted(name.as_str(), names()));
        refuse!(if named(name) == 0 || event.name.as_ref() == Some(name), "{path}.when.completed":
            "there is no other event `{awaited}` of this actor", "{known}");
    }
    if let Some(to) = &event.to {
        refuse!(if !event.when.measures(),
            "{path}.to": "this trigger measures nothing to another actor", "no `to`");
        let other = to.as_str();
        refuse!(if *to == own.name || !actors.iter().any(|actor| actor.name == *to),
            "{path}.to": "there is no other actor `{other}`", "the name of another actor");
    }
    Ok(())
}
