//! Checks of the other vehicles.

use super::fail;
use crate::Problem;
use crate::actor::{Actor, MAX_ACTORS, MAX_PROFILE_POINTS, Profile};
use crate::quantity::Time;
use crate::speeds::SpeedPoint;

pub(super) fn actors(actors: &[Actor]) -> Result<(), Problem> {
    if actors.len() > MAX_ACTORS {
        return fail("actors", format!("{} actors", actors.len()), format!("at most {MAX_ACTORS}"));
    }
    let mut points = 0;
    for (i, actor) in actors.iter().enumerate() {
        let path = format!("actors.{i}");
        if actors[..i].iter().any(|other| other.name == actor.name) {
            return fail(
                format!("{path}.name"),
                "another actor has the same name",
                "a name of its own",
            );
        }
        if actor.leaves_at_s.is_some_and(|leaves| leaves <= actor.appears_at_s) {
            return fail(
                format!("{path}.leaves_at_s"),
                "it leaves before it appears",
                format!("later than {} s", actor.appears_at_s.value()),
            );
        }
        profile(actor, &path)?;
        points += actor.profile.points().map_or(0, <[_]>::len);
        if points > MAX_PROFILE_POINTS {
            return fail(
                format!("{path}.profile"),
                "too many points in the speed tables",
                format!("at most {MAX_PROFILE_POINTS} in all actors together"),
            );
        }
        lateral(actor, &path)?;
    }
    Ok(())
}

fn profile(actor: &Actor, path: &str) -> Result<(), Problem> {
    let key = format!("{path}.profile");
    match &actor.profile {
        Profile::Constant | Profile::Sine(_) | Profile::Storyboard | Profile::Cycle(_) => {}
        Profile::Steps(steps) => increasing(&format!("{key}.steps"), steps, |step| step.time_s)?,
        Profile::Piecewise(pieces) => {
            increasing(&format!("{key}.piecewise"), pieces, |piece| piece.time_s)?;
        }
        Profile::Speeds(points) => {
            increasing(&format!("{key}.speeds"), points, |point: &SpeedPoint| point.0)?;
        }
        Profile::Csv(csv) => {
            if csv.points.is_empty() {
                return fail(
                    format!("{key}.csv"),
                    "the file has not been read, for this scenario is not a file itself",
                    "points, or a scenario file",
                );
            }
            increasing(&format!("{key}.csv.points"), &csv.points, |point| point.0)?;
        }
    }
    match (actor.profile.points(), actor.initial_speed_mps) {
        (None, None) => fail(
            format!("{path}.initial_speed_mps"),
            "missing key `initial_speed_mps`",
            "a speed, which may be 0",
        ),
        (Some(_), Some(_)) => fail(
            format!("{path}.initial_speed_mps"),
            "the speed is given twice",
            "no initial speed beside a table of speeds",
        ),
        (None, Some(initial)) if actor.max_speed_mps.is_some_and(|max| initial > max) => fail(
            format!("{path}.initial_speed_mps"),
            "the initial speed is above max_speed_mps",
            "at most the highest speed",
        ),
        _ => Ok(()),
    }
}

fn increasing<T>(path: &str, items: &[T], time: impl Fn(&T) -> Time) -> Result<(), Problem> {
    if items.is_empty() {
        return fail(path, "an empty list", "at least one entry");
    }
    if items.len() > MAX_PROFILE_POINTS {
        return fail(path, "too many entries", format!("at most {MAX_PROFILE_POINTS}"));
    }
    match items.windows(2).position(|pair| time(&pair[0]) >= time(&pair[1])) {
        None => Ok(()),
        Some(i) => fail(
            format!("{path}.{}", i + 1),
            "times must increase",
            format!("a time after {} s", time(&items[i]).value()),
        ),
    }
}

fn lateral(actor: &Actor, path: &str) -> Result<(), Problem> {
    let mut free_from = 0.0;
    for (i, motion) in actor.lateral.iter().enumerate() {
        if motion.time_s.value() < free_from {
            return fail(
                format!("{path}.lateral.{i}.time_s"),
                "this motion starts before the one before it ends",
                format!("at least {free_from} s"),
            );
        }
        if motion.rise_s.is_some_and(|rise| rise.value() > motion.duration_s.value()) {
            return Err(Problem::new(
                format!("{path}.lateral.{i}.rise_s"),
                "the lateral speed still rises when the motion is over",
                format!("at most {} s", motion.duration_s.value()),
            )
            .against(&format!("{path}.lateral.{i}.duration_s")));
        }
        free_from = motion.time_s.value() + motion.duration_s.value();
    }
    if actor.lateral.len() > 100 {
        return fail(format!("{path}.lateral"), "too many motions", "at most 100");
    }
    Ok(())
}
