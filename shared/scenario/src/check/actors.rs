//! Checks of the other vehicles.

use crate::Problem;
use crate::actor::{Actor, MAX_ACTORS, MAX_PROFILE_POINTS, Profile};
use crate::quantity::Time;
use crate::reading::refuse;
use crate::speeds::SpeedPoint;

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
            refuse!(if csv.points.is_empty(), "{key}.csv":
                "the file has not been read, for this scenario is not a file itself",
                "points, or a scenario file");
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
