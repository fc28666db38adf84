//! `timegap campaign radio`: drives through signals whose frames are lost, late and falsified.
//!
//! Each run is `corridor` with its own signal programs and its own things wrong with the air, the roadside
//! units and the on-board unit, drawn from a generator that the run's number seeds. No run may cross a red
//! light or touch another vehicle.
//!
//! ```text
//! number ─ draw ─► batch ─► journal ─► table, verdict
//! ```

mod draw;
mod table;

use crate::arguments::CampaignArguments;
use crate::planned::Planned;
use frame::batch::{self, Done, Job, Source};
use frame::parts::{Merged, Part, Study, name_incomplete};
use group::report::Outcome;
use group::{Error, ScenarioOptions};
use report::output::OutputDirectory;
use runtime::Mode;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::process::ExitCode;
use table::Table;

/// The campaign's name.
pub const NAME: &str = "radio";

/// Runs where nothing else is asked for.
const RUNS: usize = 2_000;
/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;
const SCENARIO: &str = "corridor";

/// What is kept of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Kept {
    /// The run's number, from 1.
    number: usize,
    outcome: Outcome,
    driven_s: f64,
    /// How far the vehicle came, m.
    reached_m: f64,
    frames: u64,
    verdicts: BTreeMap<String, u64>,
    /// Time that the controller was without its signals, s.
    signals_lost_s: f64,
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
        }
    }

    fn holds(&self) -> bool {
        self.outcome == Outcome::Completed
    }

    /// What broke the promise, and the command that repeats it.
    fn failure(&self) -> String {
        let outcome = report::print::outcome_word(self.outcome).to_lowercase();
        let repeat = planned(self.number).repeat("lockstep");
        format!("run {}: {outcome} after {} s\n  {repeat}", self.number, self.driven_s)
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
        parameters: Vec::new(),
    }
}

fn job(number: usize) -> Result<Job, Error> {
    let Planned { scenario, seed, keys, .. } = planned(number);
    let options = ScenarioOptions { seed: Some(seed.to_string()), ..ScenarioOptions::default() };
    Ok(Job::lockstep(group::open_with(&scenario, &options, "set", &keys)?))
}

/// Does the runs, or joins their parts.
///
/// # Errors
/// As a campaign's runs.
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    if arguments.parts.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// Does the runs that are left of this part, and tells of each that fails as it ends.
///
/// # Errors
/// As a campaign's runs.
fn drive(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let numbers = Numbers::of(arguments);
    let study = Study::of_this_command(numbers.count, &job(numbers.number(0))?.scenario);
    let options = arguments.parts.clone();
    let (mut part, output) = Part::<Kept>::open(&options, &arguments.results.output, study)?;
    let left = part.left();
    let bar = report::progress::count_bar(part.runs(), arguments.results.json);
    bar.set_message(NAME);
    bar.set_position((part.runs() - left.len()) as u64);
    bar.reset_eta();
    let repeated = part.repeated(&left, SAMPLE_SEED);
    let at_once = batch::at_once(arguments.jobs, Mode::Lockstep);
    let make = |index: usize| job(numbers.number(left[index]));
    let source = Source { runs: left.len(), make: &make };
    let mut each = |index: usize, _: &Job, result: Result<Done, Error>| {
        let done = result?;
        let kept = Kept::of(numbers.number(left[index]), &done);
        if !kept.holds() {
            bar.suspend(|| report::print::note(&kept.failure()));
        }
        part.keep(left[index], kept, done.repetition.as_ref())
    };
    let end = batch::run_made(&repeated, &source, at_once, &arguments.group, &bar, &mut each);
    part.finish(end, left.len(), &bar, &output)?;
    let shard = part.shard();
    let (results, sample) = part.into_results();
    sample.agreed(|index| format!(" (number {})", numbers.number(index)))?;
    if let Some(shard) = shard {
        let (name, directory) = (String::from(shard), output.path().display());
        eprintln!("shard {name} is in {directory}; timegap campaign --merge puts all together");
    }
    conclude(arguments, results, &output, true)
}

/// Puts parts together.
///
/// # Errors
/// Directories that are no parts of one campaign, or a file that cannot be read or written.
fn merge(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let merged = Merged::<Kept>::read(
        "campaign",
        &arguments.parts.merge,
        arguments.results.output.out.as_deref(),
    )?;
    let numbers = Numbers::of(&merged.study.arguments()?);
    merged.check(numbers.count, &job(numbers.number(0))?.scenario)?;
    name_incomplete(&merged.incomplete);
    let output = OutputDirectory::create(&arguments.results.output, NAME)?;
    let is_whole = merged.incomplete.is_empty();
    conclude(arguments, merged.into_results()?.0, &output, is_whole)
}

/// Adds up, writes and prints.
fn conclude(
    arguments: &CampaignArguments,
    results: Vec<Option<Kept>>,
    output: &OutputDirectory,
    is_whole: bool,
) -> Result<ExitCode, Error> {
    let kept: Vec<Kept> = results.into_iter().flatten().collect();
    let table = Table::of(&kept);
    let json = serde_json::to_string_pretty(&table).expect("plain data") + "\n";
    let written = output
        .write("radio.csv", table::csv(&kept).as_bytes())
        .and_then(|()| output.write("radio.json", json.as_bytes()));
    if arguments.results.json {
        report::print::out(&json)?;
    } else {
        let results = format!("results: {}\n", output.path().display());
        report::print::out(&(table.text() + &results))?;
    }
    written?;
    Ok(if table.ok && is_whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_a_scenario() {
        for number in 1..=200 {
            job(number).unwrap_or_else(|error| panic!("run {number}: {error}"));
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
        };
        let said = kept.failure();
        assert!(!kept.holds() && said.starts_with("run 7: red light after 31.5 s\n"), "{said}");
        assert!(
            said.contains("timegap run corridor --mode lockstep --seed 7 --set 'v2x."),
            "{said}"
        );
    }
}
