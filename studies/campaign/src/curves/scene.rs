//! The kinds of scenes, and the scenario of each run.

use controller::laws;
use group::{Error, LawOptions};
use scenario::{Overrides, Scenario};
use serde::{Deserialize, Serialize};

use super::NAME;
use super::queue::Queue;
use super::road::RandomRoad;
use super::sources::Sources;

/// The law that drives if the user gives no law.
pub const LAW: &str = "acc-mpc";

/// Kind of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scene {
    /// A random road with a lead and two neighbours.
    Road,
    /// An entry or exit of a curve with a queue beside the ego's lane.
    Beside,
    /// The same with the queue in the ego's lane.
    InLane,
}

impl Scene {
    /// All kinds, in the order of the runs of a number.
    pub const ALL: [Self; 3] = [Self::Road, Self::Beside, Self::InLane];

    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Road => "random road",
            Self::Beside => "queue beside",
            Self::InLane => "queue in the lane",
        }
    }

    /// Scene `number` of this kind, driven by a law, as a scenario file.
    pub fn text(self, number: u64, sources: &Sources, law: &str) -> String {
        match self {
            Self::Road => RandomRoad::new(number).text(number, sources.toml, law),
            Self::Beside => Queue::new(number).text(number, false, sources.toml, law),
            Self::InLane => Queue::new(number).text(number, true, sources.toml, law),
        }
    }

    /// The scenario of that file. A law of the user's own drives, if there is one.
    ///
    /// # Errors
    /// If the scenario is refused.
    pub fn scenario(
        self,
        number: u64,
        sources: &Sources,
        own: &LawOptions,
    ) -> Result<Scenario, Error> {
        let text = self.text(number, sources, own.only().unwrap_or(LAW));
        let mut overrides = Overrides::new();
        own.lay_over(&mut overrides)?;
        Ok(Scenario::parse_with(NAME, &text, &overrides, &laws::check)?)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sources;
    use super::*;

    #[test]
    fn every_scene_is_a_scenario_with_all_sources() {
        for number in 1..=60 {
            for scene in Scene::ALL {
                let sources = &sources::ALL[number as usize % sources::ALL.len()];
                let scenario = scene.scenario(number, sources, &LawOptions::default());
                let scenario =
                    scenario.unwrap_or_else(|error| panic!("{scene:?} {number}: {error}"));
                assert!(scenario.road.plan().is_some());
                assert_eq!(scenario.controller.name.as_str(), LAW);
            }
        }
    }

    #[test]
    fn a_law_of_the_users_own_drives_every_scene() {
        let own = LawOptions { laws: vec!["mine=cat".parse().expect("a law")] };
        for scene in Scene::ALL {
            let scenario = scene.scenario(1, &sources::JUDGED, &own);
            let scenario = scenario.unwrap_or_else(|error| panic!("{scene:?}: {error}"));
            assert_eq!(scenario.controller.name.as_str(), "mine");
        }
    }
}
