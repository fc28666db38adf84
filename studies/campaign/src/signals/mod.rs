//! `timegap campaign signals`: corridors of signals, `cacc-mpc` against an ACC whose driver stops for them.
//!
//! Each corridor is driven by both laws, and beside them stands the fastest legal trip. The radar is imperfect,
//! and the signals come as frames. `docs/signals.md` says how the figures are meant.
//!
//! ```text
//! number ─ draw ─► scenario ─► cacc-mpc, acc-signal-stop ─ judge ─► table, goals
//! ```

pub(crate) mod draw;
mod figures;
mod judge;
mod lead;
mod limits;
mod signal;
mod table;

pub use table::schema;

use std::num::{NonZeroU32, NonZeroUsize};
use std::process::ExitCode;

use controller::laws;
use draw::Corridor;
use frame::batch::{Done, Job};
use frame::{Found, Options, Study};
use group::Error;
use judge::Kept;
use report::results::Document;
use scenario::{Overrides, Scenario};

use crate::arguments::CampaignArguments;

/// The campaign's name.
pub const NAME: &str = "signals";

/// The law that is judged.
const OURS: &str = "cacc-mpc";
/// The law that it is judged by.
const RIVAL: &str = "acc-signal-stop";
/// Both, in the order of their runs.
const LAWS: [&str; 2] = [OURS, RIVAL];
/// Corridors where nothing else is asked for.
const CORRIDORS: u32 = 500;

/// The corridors of a command.
#[derive(Clone, Copy, Debug)]
struct Numbers {
    first: usize,
    count: usize,
}

impl Numbers {
    fn of(arguments: &CampaignArguments) -> Self {
        let count = arguments.seeds.map_or(CORRIDORS, NonZeroU32::get);
        Self {
            first: arguments.first.map_or(1, NonZeroUsize::get),
            count: usize::try_from(count).expect("at least 32 bits"),
        }
    }

    fn runs(self) -> usize {
        self.count * LAWS.len()
    }

    /// Corridor and law of a run.
    fn run(self, index: usize) -> (usize, &'static str) {
        (self.first + index / LAWS.len(), LAWS[index % LAWS.len()])
    }
}

/// The scenario file of corridor `number` for a law.
pub(crate) fn corridor(number: u64, law: &str) -> String {
    Corridor::new(number).text(number, law, law == RIVAL)
}

/// The scenario of that file.
fn scenario(number: usize, law: &str) -> Result<Scenario, Error> {
    Ok(Scenario::parse_with(NAME, &corridor(number as u64, law), &Overrides::new(), &laws::check)?)
}

/// Runs the campaign, or joins its parts.
///
/// # Errors
/// As [`frame::study::run`].
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    frame::study::run::<Corridors>(arguments)
}

/// The study: each corridor with each law.
struct Corridors {
    numbers: Numbers,
}

impl Study for Corridors {
    type Arguments = CampaignArguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = "campaign";

    fn options(arguments: &CampaignArguments) -> Options<'_> {
        arguments.options()
    }

    fn plan(arguments: &CampaignArguments) -> Result<Self, Error> {
        Ok(Self { numbers: Numbers::of(arguments) })
    }

    fn runs(&self) -> usize {
        self.numbers.runs()
    }

    fn label(&self) -> String {
        NAME.to_owned()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let (number, law) = self.numbers.run(run);
        Ok(Job::lockstep(scenario(number, law)?))
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Kept, ()), Error> {
        let (number, _) = self.numbers.run(run);
        Ok((Kept::of(number, &job.scenario, &result?), ()))
    }

    fn describe(&self, run: usize) -> String {
        let (number, law) = self.numbers.run(run);
        format!(" (corridor {number}, {law})")
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let kept: Vec<Kept> = found.records.all()?.into_iter().map(|(_, kept)| kept).collect();
        Ok(table::document(&kept, found.sample))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corridor_is_a_scenario_for_both_laws() {
        for number in 1..=100 {
            for law in LAWS {
                scenario(number, law).unwrap_or_else(|error| panic!("{number}, {law}: {error}"));
            }
        }
    }
}
