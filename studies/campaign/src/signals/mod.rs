//! `timegap campaign signals`: corridors of signals, `cacc-mpc` against an ACC whose driver stops for them.
//!
//! Each corridor is driven by both laws and by those of `--law`, and beside them stands the fastest legal trip. The radar is imperfect,
//! and the signals come as frames. `docs/signals.md` explains the figures.
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
use frame::{Command, Entry, Found, RunOptions, Study};
use group::{Error, LawOptions};
use judge::Kept;
use report::results::Document;
use scenario::{Overrides, Scenario};

use crate::arguments::CampaignArguments;
use crate::required;

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
}

/// The scenario file of corridor `number` for a law.
pub(crate) fn corridor(number: u64, law: &str) -> String {
    Corridor::new(number).text(number, law, law == RIVAL)
}

/// The scenario of that file. The law may be one of the user's `own`.
fn scenario(
    number: usize,
    law: &str,
    own: &LawOptions,
    require: &[String],
) -> Result<Scenario, Error> {
    let mut overrides = Overrides::new();
    own.lay_over(&mut overrides)?;
    let text = corridor(number as u64, law);
    required::add(Scenario::parse_with(NAME, &text, &overrides, &laws::check)?, require)
}

/// Runs the campaign, or joins its parts.
///
/// # Errors
/// As [`frame::run`].
pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    frame::run::<Corridors>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Corridors>();

/// The study: each corridor with each law.
struct Corridors {
    numbers: Numbers,
    /// In the order of the runs of a corridor.
    laws: Vec<String>,
    own: LawOptions,
    /// Requirements of the command.
    require: Vec<String>,
}

impl Corridors {
    /// Corridor and law of a run.
    fn run(&self, index: usize) -> (usize, &str) {
        let laws = self.laws.len();
        (self.numbers.first + index / laws, &self.laws[index % laws])
    }
}

impl Study for Corridors {
    type Arguments = CampaignArguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = NAME;

    fn plan(arguments: &CampaignArguments, _: &RunOptions) -> Result<Self, Error> {
        let own = arguments.laws.clone();
        own.check()?;
        let laws = LAWS.map(str::to_owned).into_iter().chain(own.names()).collect();
        let require = arguments.require.clone();
        Ok(Self { numbers: Numbers::of(arguments), laws, own, require })
    }

    fn runs(&self) -> usize {
        self.numbers.count * self.laws.len()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let (number, law) = self.run(run);
        Ok(Job::lockstep(scenario(number, law, &self.own, &self.require)?))
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Kept, ()), Error> {
        let kept = Kept::of(self.run(run).0, &job.scenario, &result?);
        let mut options = self.own.words();
        options.extend(required::words(&self.require));
        Ok((Kept { options, ..kept }, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        vec![("corridor".to_owned(), self.run(run).0.to_string())]
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let kept: Vec<Kept> = found.records.all()?.into_iter().map(|(_, kept)| kept).collect();
        Ok(table::document(&kept))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corridor_is_a_scenario_for_both_laws() {
        for number in 1..=100 {
            for law in LAWS {
                scenario(number, law, &LawOptions::default(), &[])
                    .unwrap_or_else(|error| panic!("{number}, {law}: {error}"));
            }
        }
    }
}
