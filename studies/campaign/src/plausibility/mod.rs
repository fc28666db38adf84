//! `timegap campaign plausibility`: false alarms of the controller's checks of its inputs, and the time until they
//! find a false sender.
//!
//! ```text
//! seed, number ─ draw ─► drive without faults ─► false alarms per hour, by check and by kind
//! scenario, fault ─ cases ─► drive ─► found or not, after how long
//! ```
//!
//! The drives without faults are random and of many kinds ([`draw`]): `--hours H` of them from `--seed S` on.

mod cases;
mod draw;
mod rate;
mod table;

use crate::arguments::CampaignArguments;
use cases::{BIAS, CASES, FREEZE};
use frame::batch::{self, Job, Source};
use group::{Error, ScenarioOptions};
use runtime::Mode;
use std::collections::BTreeSet;
use std::process::ExitCode;
use table::Table;

/// The table of the controller's checks, which is no campaign of its own.
pub const NAME: &str = "plausibility";

/// Hours without faults where nothing else is asked for: less than a minute on two cores.
const HOURS: f64 = 3.0;
/// Drives with each fault.
const DRIVES: u32 = 20;

/// One drive of the table.
#[derive(Clone, Copy, Debug)]
enum Planned {
    /// A random drive by its number.
    Quiet(usize),
    /// A false sender by its place in [`CASES`], and the drive with it.
    Faulty(usize, u32),
}

/// When the fault of a drive begins, s: spread over the time that its case allows.
fn begins_s(case: usize, drive: u32) -> f64 {
    let (.., from_s, to_s) = CASES[case];
    let at_s = from_s + (to_s - from_s) * f64::from(drive) / f64::from(DRIVES - 1);
    (at_s * 100.0).round() / 100.0
}

fn job(seed: u32, planned: Planned) -> Result<Job, Error> {
    match planned {
        Planned::Quiet(number) => Ok(Job::lockstep(draw::drive(seed, number)?.1)),
        Planned::Faulty(case, drive) => {
            let (_, _, scenario, keys, ..) = CASES[case];
            let kind = if keys.contains("field") { BIAS } else { FREEZE };
            let at_s = begins_s(case, drive);
            let keys = [
                format!("duration_s={:.2}", at_s + 12.0),
                format!("faults=[{{ {kind}{keys}, at_s = {at_s:.2} }}]"),
            ];
            let seed = Some((drive + 1).to_string());
            let options = ScenarioOptions { seed, ..ScenarioOptions::default() };
            Ok(Job::lockstep(group::open_with(scenario, &options, "set", &keys)?))
        }
    }
}

/// The random drives that fill these hours.
fn quiet(seed: u32, hours: f64) -> Result<Vec<Planned>, Error> {
    let mut left_s = hours * 3600.0;
    let mut planned = Vec::new();
    while left_s > 0.0 {
        let (_, scenario) = draw::drive(seed, planned.len())?;
        left_s -= scenario.duration_s.value();
        planned.push(Planned::Quiet(planned.len()));
    }
    Ok(planned)
}

/// Runs the drives and prints the table. Fails if a check found something where nothing was.
///
/// # Errors
/// As a campaign's runs.
pub fn run(arguments: &CampaignArguments) -> Result<ExitCode, Error> {
    let seed = arguments.seed.unwrap_or(1);
    let mut planned = quiet(seed, arguments.hours.map_or(HOURS, f64::from))?;
    for case in 0..CASES.len() {
        planned.extend((0..DRIVES).map(|drive| Planned::Faulty(case, drive)));
    }
    let mut table = Table::new(seed);
    let bar = report::progress::count_bar(planned.len(), arguments.results.json);
    bar.set_message(NAME);
    let make = |index: usize| job(seed, planned[index]);
    let source = Source { runs: planned.len(), make: &make };
    let at_once = batch::at_once(arguments.jobs, Mode::Lockstep);
    let mut each = |index: usize, job: &Job, result: Result<batch::Done, Error>| {
        let done = result?;
        match planned[index] {
            Planned::Quiet(number) => table.quiet(draw::kind(number), job, &done),
            Planned::Faulty(case, drive) => table.faulty(case, begins_s(case, drive), &done),
        }
        Ok(())
    };
    let none = BTreeSet::new();
    let end = batch::run_made(&none, &source, at_once, &arguments.group, &bar, &mut each);
    bar.finish_and_clear();
    end?;
    table.finish();
    let text = if arguments.results.json {
        serde_json::to_string_pretty(&table).expect("plain data") + "\n"
    } else {
        table.text()
    };
    report::print::out(&text)?;
    Ok(if table.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
