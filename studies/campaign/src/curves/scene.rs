//! The kinds of scenes, and the scenario of each run.

use controller::laws;
use group::Error;
use scenario::{Overrides, Scenario};
use serde::{Deserialize, Serialize};

use super::NAME;
use super::queue::Queue;
use super::road::RandomRoad;
use super::sources::Sources;

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

    /// Scene `number` of this kind as a scenario file.
    pub fn text(self, number: u64, sources: &Sources) -> String {
        match self {
            Self::Road => RandomRoad::new(number).text(number, sources.toml),
            Self::Beside => Queue::new(number).text(number, false, sources.toml),
            Self::InLane => Queue::new(number).text(number, true, sources.toml),
        }
    }

    /// The scenario of that file.
    ///
    /// # Errors
    /// If the scenario is refused.
    pub fn scenario(self, number: u64, sources: &Sources) -> Result<Scenario, Error> {
        let text = self.text(number, sources);
        Ok(Scenario::parse_with(NAME, &text, &Overrides::new(), &laws::check)?)
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
                let scenario = scene.scenario(number, sources);
                let scenario =
                    scenario.unwrap_or_else(|error| panic!("{scene:?} {number}: {error}"));
                assert!(scenario.road.plan().is_some());
            }
        }
    }
}
