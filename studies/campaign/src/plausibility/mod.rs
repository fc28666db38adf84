//! `timegap campaign plausibility`: false alarms of the controller's checks of its inputs, and the time until they
//! find a false sender.
//!
//! ```text
//! seed, number ─ draw ─► drive without faults ─► false alarms per hour, by check and by kind
//! scenario, fault ─ cases ─► drive ─► found or not, after how long
//! ```
//!
//! The drives without faults are random and of many kinds ([`draw`]): `--hours H` of them from `--seed S` on. A law of
//! `--law` drives all cars. Trucks keep their own.

mod cases;
mod draw;
mod radar_figures;
mod results;
mod table;

pub use radar_figures::radar_figures;
pub use table::schema;

use std::process::ExitCode;

use frame::batch::{Done, Job};
use frame::{Command, Entry, Found, RunOptions, Study};
use group::report::CheckReport;
use group::{Error, LawOptions, RequirementVerdict, ScenarioOptions};
use report::results::Document;
use report::verdicts;
use scenario::Scenario;
use scenario::plant::Vehicle;
use serde::{Deserialize, Serialize};

use crate::arguments::CampaignArguments;
use crate::required;
use cases::{BIAS, CASES, FREEZE};

/// The campaign's name.
pub const NAME: &str = "plausibility";

/// Hours without faults where nothing else is asked for: less than a minute on two cores.
const HOURS: f64 = 3.0;
/// Drives with each fault.
const DRIVES: u32 = 20;

/// A planned drive.
#[derive(Clone, Copy, Debug)]
enum Planned {
    /// A random drive by its number.
    Quiet(usize),
    /// A false sender by its place in [`CASES`], and the drive with it.
    Faulty(usize, u32),
}

/// The record of a drive.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Kept {
    /// Name of its scenario.
    scenario: String,
    duration_s: f64,
    /// The findings of each check.
    checks: Vec<CheckReport>,
    /// Verdicts on the requirements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    requirements: Vec<RequirementVerdict>,
}

/// Start of a drive's fault, s, spread over the time that its case allows.
fn begins_s(case: usize, drive: u32) -> f64 {
    let (.., from_s, to_s) = CASES[case];
    let at_s = from_s + (to_s - from_s) * f64::from(drive) / f64::from(DRIVES - 1);
    (at_s * 100.0).round() / 100.0
}

fn scenario(seed: u32, laws: &LawOptions, planned: Planned) -> Result<Scenario, Error> {
    match planned {
        Planned::Quiet(number) => Ok(draw::drive(seed, number, laws)?.1),
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
            let mut drive = group::open_with(scenario, &options, "set", &keys)?;
            if !laws.laws.is_empty() && drive.plant.vehicle == Vehicle::Car {
                let options = ScenarioOptions { laws: laws.clone(), ..options };
                drive = group::open_with(scenario, &options, "set", &keys)?;
            }
            Ok(drive)
        }
    }
}

/// The random drives that fill these hours.
fn quiet(seed: u32, laws: &LawOptions, hours: f64) -> Result<Vec<Planned>, Error> {
    let mut left_s = hours * 3600.0;
    let mut planned = Vec::new();
    while left_s > 0.0 {
        let (_, scenario) = draw::drive(seed, planned.len(), laws)?;
        left_s -= scenario.duration_s.value();
        planned.push(Planned::Quiet(planned.len()));
    }
    Ok(planned)
}

/// Runs the campaign, or joins its parts.
///
/// # Errors
/// As [`frame::run`].
pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    frame::run::<Checks>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Checks>();

/// The study: random drives without faults, then the drives with each false sender.
struct Checks {
    seed: u32,
    /// The law of the user's own, or none.
    laws: LawOptions,
    drives: Vec<Planned>,
    /// Requirements of the command.
    require: Vec<String>,
}

impl Study for Checks {
    type Arguments = CampaignArguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = NAME;

    fn plan(arguments: &CampaignArguments, _: &RunOptions) -> Result<Self, Error> {
        let seed = arguments.seed.unwrap_or(1);
        let laws = arguments.one_law(NAME)?.clone();
        let mut drives = quiet(seed, &laws, arguments.hours.map_or(HOURS, f64::from))?;
        for case in 0..CASES.len() {
            drives.extend((0..DRIVES).map(|drive| Planned::Faulty(case, drive)));
        }
        Ok(Self { seed, laws, drives, require: arguments.require.clone() })
    }

    fn runs(&self) -> usize {
        self.drives.len()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let drive = scenario(self.seed, &self.laws, self.drives[run])?;
        Ok(Job::lockstep(required::add(drive, &self.require)?))
    }

    fn record(
        &self,
        _: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Kept, ()), Error> {
        let summary = result?.summary;
        let scenario = job.scenario.name.as_str().to_owned();
        let kept = Kept {
            scenario,
            duration_s: summary.duration_s,
            checks: summary.checks,
            requirements: summary.requirements,
        };
        Ok((kept, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let (fault, drive) = match self.drives[run] {
            Planned::Quiet(number) => ("none".to_owned(), number + 1),
            Planned::Faulty(case, drive) => {
                let (fault, size, ..) = CASES[case];
                (format!("{fault} {size}"), drive as usize + 1)
            }
        };
        vec![("fault".to_owned(), fault), ("drive".to_owned(), drive.to_string())]
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let kept = found.records.all()?;
        let mut results = results::Results::new(self.seed, self.laws.only());
        for (run, kept) in &kept {
            match self.drives[*run] {
                Planned::Quiet(number) => results.quiet(draw::kind(number), kept),
                Planned::Faulty(case, drive) => results.faulty(case, begins_s(case, drive), kept),
            }
        }
        results.finish();
        results.require(verdicts::least(kept.iter().map(|(run, kept)| {
            let name = match self.drives[*run] {
                Planned::Quiet(number) => format!("{}-{number}", draw::kind(number)),
                Planned::Faulty(case, drive) => {
                    let (fault, size, ..) = CASES[case];
                    format!("{fault} {size}, drive {}", drive + 1)
                }
            };
            (name, kept.requirements.as_slice())
        })));
        Ok(table::document(&results))
    }
}
