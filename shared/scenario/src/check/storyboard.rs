//! Checks of a storyboard: it belongs to the actors.

use openscenario::World;
use openscenario::model::Drive;

use crate::actor::{Actor, Profile};
use crate::{Problem, Scenario};

/// Actors and storyboard belong together.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    let follows = |actor: &&Actor| actor.profile == Profile::Storyboard;
    let actors = scenario.actors.iter().filter(follows).count();
    let first = scenario.actors.iter().position(|actor| follows(&actor)).unwrap_or(0);
    let Some(storyboard) = &scenario.storyboard else {
        return match actors {
            0 => Ok(()),
            _ => Err(Problem::new(
                format!("actors.{first}.profile"),
                "there is no storyboard to follow",
                "another profile, or a scenario made from an OpenSCENARIO file",
            )),
        };
    };
    let script = &storyboard.script;
    if let Err(cause) = World::new(script.clone()) {
        return Err(Problem::new(
            "storyboard.script",
            cause.to_string(),
            "a script that holds together",
        ));
    }
    let moved = script.entities.iter().filter(|entity| entity.drive == Drive::Scripted).count();
    if moved != actors || scenario.actors.len() != actors {
        return Err(Problem::new(
            "storyboard.script.entities",
            format!("{moved} entities for {actors} of {} actors", scenario.actors.len()),
            "one actor with the profile `storyboard` for each entity that it moves, and no others",
        )
        .against("actors"));
    }
    Ok(())
}
