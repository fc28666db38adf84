//! `[storyboard]`: the content of an OpenSCENARIO file, carried in the scenario.
//!
//! The storyboard is carried as it was resolved: parameters, catalogs and road included. A service that receives the
//! scenario needs no other file. The module `translation` makes a scenario of an OpenSCENARIO file.

use std::collections::BTreeMap;

use openscenario::World;
use openscenario::model::{Drive, Script};
use serde::{Deserialize, Serialize};

use super::Scenario;
use super::actor::Profile;
use super::problem::Problem;
use super::schema::{Schema, Shape};

/// A storyboard with where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Storyboard {
    /// The file that it was read from.
    pub source: String,
    /// Remarks on its simulation, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
    /// Reason why its story cannot happen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hindrance: Option<String>,
    /// The file's parameters with the values that took effect.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, String>,
    /// Its content.
    pub script: Script,
}

impl Schema for Storyboard {
    /// A translation fills it.
    fn shape() -> Shape {
        Shape::Free
    }
}

impl Scenario {
    /// Reason why the story of its OpenSCENARIO file cannot happen, as far as that is known before the drive.
    ///
    /// ```
    /// let text = scenario::builtin::find("cut-in").expect("built in").text;
    /// assert_eq!(scenario::Scenario::parse("cut-in", text)?.hindrance(), None);
    /// # Ok::<(), scenario::ScenarioError>(())
    /// ```
    #[must_use]
    pub fn hindrance(&self) -> Option<String> {
        let storyboard = self.storyboard.as_ref()?;
        let stands =
            self.set_speed_mps.value() == 0.0 && self.plant.initial_speed_mps.value() == 0.0;
        let waits = || "the ego stands, and its set speed is 0 m/s".to_owned();
        storyboard.hindrance.clone().or_else(|| stands.then(waits))
    }
}

/// Actors and storyboard belong together.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    let follows = |actor: &&super::actor::Actor| actor.profile == Profile::Storyboard;
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
