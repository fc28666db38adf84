//! Checks of the other vehicles, their events and their storyboard.

use openscenario::World;
use openscenario::model::Drive;

use crate::actor::{Actor, MAX_ACTORS, MAX_PROFILE_POINTS, Profile};
use crate::event::{ActorEvent, MAX_EVENTS, When};
use crate::name::Name;
use crate::quantity::Time;
use crate::reading::refuse;
use crate::speeds::SpeedPoint;
use crate::{Problem, Scenario, accepted};

/// Most lateral motions of an actor.
const MAX_LATERAL: usize = 100;

pub(super) fn actors(actors: &[Actor]) -> Result<(), Problem> {
    let count = actors.len();
    refuse!(if count > MAX_ACTORS, "actors": "{count} actors", "at most {MAX_ACTORS}");
    let mut points = 0;
    for (i, actor) in actors.iter().enumerate() {
        refuse!(if actors[..i].iter().any(|other| other.name == actor.name),
            "actors.{i}.name": "another actor has the same name", "a name of its own");
        let appears_at_s = actor.appears_at_s.value();
        refuse!(if actor.leaves_at_s.is_some_and(|leaves| leaves.value() <= appears_at_s),
            "actors.{i}.leaves_at_s": "it leaves before it appears", "later than {appears_at_s} s");
        profile(actor, i)?;
        points += actor.profile.points().map_or(0, <[_]>::len);
        refuse!(if points > MAX_PROFILE_POINTS, "actors.{i}.profile":
            "too many points in the speed tables",
            "at most {MAX_PROFILE_POINTS} in all actors together");
        lateral(actor, i)?;
    }
    Ok(())
}

fn profile(actor: &Actor, i: usize) -> Result<(), Problem> {
    let key = format!("actors.{i}.profile");
    match &actor.profile {
        Profile::Constant | Profile::Sine(_) | Profile::Storyboard => {}
        Profile::Sumo | Profile::Cycle(_) => {}
        Profile::Steps(steps) => increasing(&format!("{key}.steps"), steps, |step| step.time_s)?,
        Profile::Piecewise(pieces) => {
            increasing(&format!("{key}.piecewise"), pieces, |piece| piece.time_s)?;
        }
        Profile::Speeds(points) => {
            increasing(&format!("{key}.speeds"), points, |point: &SpeedPoint| point.0)?;
        }
        Profile::Csv(csv) => {
            if csv.points.is_empty() {
                return Err(Problem::unread(&format!("{key}.csv"), "points, or a scenario file"));
            }
            increasing(&format!("{key}.csv.points"), &csv.points, |point| point.0)?;
        }
    }
    let (is_table, initial) = (actor.profile.points().is_some(), actor.initial_speed_mps);
    refuse!(if !is_table && initial.is_none(), "actors.{i}.initial_speed_mps":
        "missing key `initial_speed_mps`", "a speed, which may be 0");
    refuse!(if is_table && initial.is_some(), "actors.{i}.initial_speed_mps":
        "the speed is given twice", "no initial speed beside a table of speeds");
    refuse!(if actor.max_speed_mps.is_some_and(|max| initial > Some(max)),
        "actors.{i}.initial_speed_mps": "the initial speed is above max_speed_mps",
        "at most the highest speed");
    Ok(())
}

fn increasing<T>(path: &str, items: &[T], time: impl Fn(&T) -> Time) -> Result<(), Problem> {
    refuse!(if items.is_empty(), "{path}": "an empty list", "at least one entry");
    refuse!(if items.len() > MAX_PROFILE_POINTS,
        "{path}": "too many entries", "at most {MAX_PROFILE_POINTS}");
    for (i, pair) in items.windows(2).enumerate() {
        let (next, before_s) = (i + 1, time(&pair[0]).value());
        refuse!(if before_s >= time(&pair[1]).value(),
            "{path}.{next}": "times must increase", "a time after {before_s} s");
    }
    Ok(())
}

fn lateral(actor: &Actor, i: usize) -> Result<(), Problem> {
    let mut free_from = 0.0;
    for (k, motion) in actor.lateral.iter().enumerate() {
        let (begin_s, duration_s) = (motion.time_s.value(), motion.duration_s.value());
        refuse!(if begin_s < free_from, "actors.{i}.lateral.{k}.time_s":
            "this motion starts before the one before it ends", "at least {free_from} s");
        refuse!(if motion.rise_s.is_some_and(|rise| rise.value() > duration_s),
            "actors.{i}.lateral.{k}.rise_s":
            "the lateral speed still rises when the motion is over", "at most {duration_s} s",
            against "actors.{i}.lateral.{k}.duration_s");
        free_from = begin_s + duration_s;
    }
    refuse!(if actor.lateral.len() > MAX_LATERAL,
        "actors.{i}.lateral": "too many motions", "at most {MAX_LATERAL}");
    Ok(())
}

/// The events of actors hold together.
pub(super) fn events(actors: &[Actor]) -> Result<(), Problem> {
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

/// Actors and storyboard belong together.
pub(super) fn storyboard(scenario: &Scenario) -> Result<(), Problem> {
    let follows = |actor: &Actor| actor.profile == Profile::Storyboard;
    let Some(storyboard) = &scenario.storyboard else {
        refuse!(if let Some(first) = scenario.actors.iter().position(follows),
            "actors.{first}.profile": "there is no storyboard to follow",
            "another profile, or a scenario made from an OpenSCENARIO file");
        return Ok(());
    };
    let script = &storyboard.script;
    refuse!(if let Err(cause) = World::new(script.clone()),
        "storyboard.script": "{cause}", "a script that holds together");
    let moved = script.entities.iter().filter(|entity| entity.drive == Drive::Scripted).count();
    let actors = scenario.actors.iter().filter(|actor| follows(actor)).count();
    let all = scenario.actors.len();
    refuse!(if moved != actors || all != actors, "storyboard.script.entities":
        "{moved} entities for {actors} of {all} actors",
        "one actor with the profile `storyboard` for each entity that it moves, and no others",
        against "actors");
    Ok(())
}
