//! `timegap campaign radio`: drives through signals whose frames are lost, late and falsified.
//!
//! Each run is `corridor` with its own signal programs, driven by the scenario's law or by the one of `--law`. The
//! run's number seeds a generator. It draws the faults of the air, of the roadside units and of the on-board unit. No
//! run may cross a red light or touch another vehicle.

mod draw;
mod table;

pub use table::schema;

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::process::ExitCode;

use frame::batch::{Done, Job};
use frame::{Command, Entry, Found, RunOptions, Study};
use group::report::Outcome;
use group::{Error, LawOptions, RequirementVerdict, ScenarioOptions};
use report::results::Document;
use serde::{Deserialize, Serialize};

use crate::arguments::CampaignArguments;
use crate::planned::Planned;

/// The campaign's name.
pub const NAME: &str = "radio";

/// Runs where nothing else is asked for.
const RUNS: usize = 2_000;
const SCENARIO: &str = "corridor";

/// The record of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// The run's number, from 1.
    number: usize,
    outcome: Outcome,
    driven_s: f64,
    /// Position of the vehicle at the end, m.
    reached_m: f64,
    frames: u64,
    verdicts: BTreeMap<String, u64>,
    /// Time that the controller was without its signals, s.
    signals_lost_s: f64,
    /// The options that declare a law of the user's own, as words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    law_options: Vec<String>,
    /// Verdicts on the requirements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    requirements: Vec<RequirementVerdict>,
}

impl Kept {
    fn of(number: usize, done: &Done) -> Self {
        let summary = &done.summary;
        let levels = summary.rungs.get("controller").map(|levels| &levels.time_s);
        let lost_s = levels.and_then(|levels| levels.get("signals-lost"));
        let radio = summary.radio.as_ref();
        Self {
            number,
            outcome: summary.outcome,
            driven_s: summary.duration_s,
            reached_m: done.drive.steps.last().map_or(0.0, |step| step.position_m),
            frames: radio.map_or(0, |radio| radio.frames),
            verdicts: radio.map(|radio| radio.verdicts.clone()).unwrap_or_default(),
            signals_lost_s: lost_s.copied().unwrap_or(0.0),
            law_options: Vec::new(),
            requirements: summary.requirements.clone(),
        }
    }

    fn holds(&self) -> bool {
        self.outcome == Outcome::Completed
    }

    /// The command that repeats it.
    fn repeat(&self) -> String {
        let formulas = self.requirements.iter().map(|verdict| verdict.requirement.clone());
        let planned = Planned { formulas: formulas.collect(), ..planned(self.number) };
        let command = planned.repeat("lockstep");
        match self.law_options.as_slice() {
            [] => command,
            words => format!("{command} {}", runtime::command_line(words)),
        }
    }

    /// The failure, and the command that repeats it.
    fn failure(&self) -> String {
        let outcome = report::print::outcome_word(self.outcome).to_lowercase();
        let (number, driven_s, repeat) = (self.number, self.driven_s, self.repeat());
        format!("run {number}: {outcome} after {driven_s} s\n  {repeat}")
    }
}

/// The numbers of the runs.
#[derive(Clone, Copy, Debug)]
struct Numbers {
    first: usize,
    count: usize,
}

impl Numbers {
    fn of(arguments: &CampaignArguments) -> Self {
        let first = arguments.first.map_or(1, NonZeroUsize::get);
        let count = arguments.sample.map_or_else(
            || (RUNS + 1).saturating_sub(first).max(1), // to the last of them
            NonZeroUsize::get,
        );
        Self { first, count }
    }

    fn number(self, index: usize) -> usize {
        self.first + index
    }
}

/// Run `number`, counted from 1.
fn planned(number: usize) -> Planned {
    Planned {
        run: number,
        scenario: SCENARIO.to_owned(),
        controller: None,
        fault: String::new(),
        seed: u32::try_from(number).unwrap_or(u32::MAX),
        keys: draw::keys(number as u64),
        formulas: Vec::new(),
        parameters: Vec::new(),
    }
}

fn job(number: usize, laws: &LawOptions, require: &[String]) -> Result<Job, Error> {
    let Planned { scenario, seed, keys, .. } = planned(number);
    let (seed, laws, require) = (Some(seed.to_string()), laws.clone(), require.to_vec());
    let options = ScenarioOptions { seed, laws, require, ..ScenarioOptions::default() };
    Ok(Job::lockstep(group::open_with(&scenario, &options, "set", &keys)?))
}

/// Runs the campaign, or joins its parts.
///
/// # Errors
/// As [`frame::run`].
pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    frame::run::<Drives>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Drives>();

/// The study: each number is a run.
struct Drives {
    numbers: Numbers,
    /// The law of the user's own, or none.
    laws: LawOptions,
    /// Requirements of the command.
    require: Vec<String>,
}

impl Study for Drives {
    type Arguments = CampaignArguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = NAME;

    fn plan(arguments: &CampaignArguments, _: &RunOptions) -> Result<Self, Error> {
        let laws = arguments.one_law(NAME)?.clone();
        Ok(Self { numbers: Numbers::of(arguments), laws, require: arguments.require.clone() })
    }

    fn runs(&self) -> usize {
        self.numbers.count
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        job(self.numbers.number(run), &self.laws, &self.require)
    }

    fn record(
        &self,
        run: usize,
        _: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Kept, ()), Error> {
        let kept = Kept::of(self.numbers.number(run), &result?);
        Ok((Kept { law_options: self.laws.words(), ..kept }, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        vec![("number".to_owned(), self.numbers.number(run).to_string())]
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
    fn every_run_is_a_scenario() {
        for number in 1..=200 {
            job(number, &LawOptions::default(), &[])
                .unwrap_or_else(|error| panic!("run {number}: {error}"));
        }
    }

    #[test]
    fn a_failure_comes_with_the_command_that_repeats_it() {
        let kept = Kept {
            number: 7,
            outcome: Outcome::RedLight,
            driven_s: 31.5,
            reached_m: 300.2,
            frames: 0,
            verdicts: BTreeMap::new(),
            signals_lost_s: 0.0,
            law_options: vec!["--law".to_owned(), "mine=./law".to_owned()],
            requirements: Vec::new(),
        };
        let said = kept.failure();
        assert!(!kept.holds() && said.starts_with("run 7: red light after 31.5 s\n"), "{said}");
        assert!(
            said.contains("timegap run corridor --mode lockstep --seed 7 --set 'v2x."),
            "{said}"
        );
        assert!(said.ends_with(" --law 'mine=./law'"), "{said}");
    }
}
