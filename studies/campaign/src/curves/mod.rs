//! `campaign curves`: whom the ego follows on curved roads, by ground truth.
//!
//! Perception has to find the vehicle in the ego's lane, and on a curve the lane is not straight ahead. Each scene
//! is driven with five sets of sources of the course. The first is empty (a straight path), and the second has the yaw
//! rate. The other three add standing objects, trails and the map one after the other. `docs/curves.md` explains the
//! figures.
//!
//! ```text
//! number ─ road, queue ─► scenario x sources ─► drive ─ report::targets ─► sums by part of a curve ─► table, limits
//! ```

mod draw;
mod event;
mod event_rows;
mod figures;
mod judge;
mod limits;
mod queue;
mod road;
mod scene;
mod sources;
mod table;

pub use table::schema;

use std::num::{NonZeroU32, NonZeroUsize};
use std::process::ExitCode;

use frame::batch::{Done, Job};
use frame::{Command, Entry, Found, RunOptions, Study};
use group::{Error, LawOptions};
use judge::Kept;
use report::results::Document;
use scene::Scene;
use sources::Sources;

use crate::arguments::CampaignArguments;
use crate::required;

/// The campaign's name.
pub const NAME: &str = "curves";

/// Numbers where nothing else is asked for: each has a scene of each kind.
const NUMBERS: u32 = 1_000;

/// Runs of a number: each kind of scene with each set of sources.
const RUNS: usize = Scene::ALL.len() * sources::ALL.len();

/// Runs the campaign, or joins its parts.
///
/// # Errors
/// As [`frame::run`].
pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    frame::run::<Curves>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Curves>();

/// The study: each scene with each set of sources.
struct Curves {
    first: usize,
    count: usize,
    /// The law of the user's own, or none.
    laws: LawOptions,
    /// Requirements of the command.
    require: Vec<String>,
}

impl Curves {
    /// Number, scene and sources of a run.
    fn run(&self, index: usize) -> (usize, Scene, &'static Sources) {
        let (number, of_number) = (self.first + index / RUNS, index % RUNS);
        let (scene, sources) = (of_number / sources::ALL.len(), of_number % sources::ALL.len());
        (number, Scene::ALL[scene], &sources::ALL[sources])
    }
}

impl Study for Curves {
    type Arguments = CampaignArguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = NAME;

    fn plan(arguments: &CampaignArguments, _: &RunOptions) -> Result<Self, Error> {
        let count = arguments.seeds.map_or(NUMBERS, NonZeroU32::get);
        Ok(Self {
            first: arguments.first.map_or(1, NonZeroUsize::get),
            count: usize::try_from(count).expect("at least 32 bits"),
            laws: arguments.one_law(NAME)?.clone(),
            require: arguments.require.clone(),
        })
    }

    fn runs(&self) -> usize {
        self.count * RUNS
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let (number, scene, sources) = self.run(run);
        let scenario = scene.scenario(number as u64, sources, &self.laws)?;
        Ok(Job::lockstep(required::add(scenario, &self.require)?))
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Kept, ()), Error> {
        let (number, scene, sources) = self.run(run);
        let kept = Kept::of((number, scene, sources.name), &job.scenario, &result?);
        Ok((Kept { law_options: self.laws.words(), ..kept }, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let (number, scene, sources) = self.run(run);
        let keys = [
            ("number", number.to_string()),
            ("scene", scene.name().to_owned()),
            ("sources", sources.name.to_owned()),
        ];
        keys.map(|(key, value)| (key.to_owned(), value)).to_vec()
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let kept: Vec<Kept> = found.records.all()?.into_iter().map(|(_, kept)| kept).collect();
        Ok(table::document(&kept, &self.laws))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_every_scene_with_every_source() {
        let study = Curves { first: 3, count: 2, laws: LawOptions::default(), require: Vec::new() };
        assert_eq!(study.runs(), 30);
        let runs: Vec<_> = (0..study.runs()).map(|index| study.run(index)).collect();
        for number in [3, 4] {
            for scene in Scene::ALL {
                for sources in &sources::ALL {
                    assert!(runs.contains(&(number, scene, sources)));
                }
            }
        }
    }
}
