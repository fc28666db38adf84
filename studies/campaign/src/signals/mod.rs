//! `timegap campaign signals`: corridors of signals, `cacc-mpc` against an ACC whose driver stops for them.
//!
//! Each corridor is driven by both laws, and beside them stands the fastest legal trip. The radar is imperfect,
//! and the signals come as frames. `docs/signals.md` says how the figures are meant.
//!
//! ```text
//! number ─ draw ─► scenario ─► cacc-mpc, acc-signal-stop ─ judge ─► table, goals
//! ```

pub(crate) mod draw;
mod judge;
mod lead;
mod limits;
mod signal;
mod table;

use crate::arguments::CampaignArguments;
use controller::laws;
use draw::Corridor;
use frame::batch::{self, Done, Job, ProcessesSample, Source};
use group::Error;
use judge::Kept;
use report::output::OutputDirectory;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::num::{NonZeroU32, NonZeroUsize};
use std::process::ExitCode;
use table::Table;

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
/// Chooses the runs that are repeated in process groups.
const SAMPLE_SEED: u64 = 1;

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

/// A corridor's scenario file for a law.
fn text(number: usize, law: &str) -> String {
    corridor(number as u64, law)
}

/// The scenario of that file.
fn scenario(number: usize, law: &str) -> Result<Scenario, Error> {
    Ok(Scenario::parse_with(NAME, &text(number, law), &Overrides::new(), &laws::check)?)
}

/// Drives all corridors and judges them.
///
/// # Errors
/// What keeps the runs from starting, or a file that cannot be written.
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let numbers = Numbers::of(arguments);
    let output = OutputDirectory::create(&arguments.results.output, NAME)?;
    let bar = report::progress::count_bar(numbers.runs(), arguments.results.json);
    bar.set_message(NAME);
    let repeated = batch::choose(SAMPLE_SEED, numbers.runs());
    let make = |index: usize| {
        let (number, law) = numbers.run(index);
        Ok(Job::lockstep(scenario(number, law)?))
    };
    let source = Source { runs: numbers.runs(), make: &make };
    let mut runs = vec![None; numbers.runs()];
    let mut each = |index: usize, job: &Job, result: Result<Done, Error>| {
        let (number, _) = numbers.run(index);
        runs[index] = Some(Kept::of(number, &job.scenario, &result?));
        Ok(())
    };
    let at_once = batch::at_once(arguments.jobs, Mode::Lockstep);
    let end = batch::run_made(&repeated, &source, at_once, &arguments.group, &bar, &mut each);
    bar.finish_and_clear();
    let sample = end?;
    sample.print(numbers.runs(), &bar);
    let describe =
        |index| format!(" (corridor {}, {})", numbers.run(index).0, numbers.run(index).1);
    let sample = sample.agreed(describe)?;
    conclude(arguments, &runs.into_iter().flatten().collect::<Vec<_>>(), sample, &output)
}

/// Adds up, writes and prints.
fn conclude(
    arguments: &CampaignArguments,
    runs: &[Kept],
    sample: ProcessesSample,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let table = Table::of(runs, sample);
    let json = serde_json::to_string_pretty(&table).expect("plain data") + "\n";
    let mut failed = runs.iter().filter(|run| !run.holds());
    let written = failed
        .try_for_each(|run| {
            let text = text(run.corridor, &run.law);
            output.write(&format!("corridor-{}-{}.toml", run.corridor, run.law), text.as_bytes())
        })
        .and_then(|()| output.write("signals.csv", table::csv(runs).as_bytes()))
        .and_then(|()| output.write("signals.json", json.as_bytes()));
    if arguments.results.json {
        report::print::out(&json)?;
    } else {
        let results = format!("results: {}\n", output.path().display());
        report::print::out(&(table.text() + &results))?;
    }
    written?;
    Ok(if table.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
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
