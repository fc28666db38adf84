//! Checks of a storyboard: it belongs to the actors.

use openscenario::World;
use openscenario::model::Drive;

use crate::actor::{Actor, Profile};
use crate::reading::refuse;
use crate::{Problem, Scenario};

/// Actors and storyboard belong together.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
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
