//! `timegap campaign plausibility`: how good the controller's checks of its inputs are.
//!
//! Ten hours of drives without faults show how often each check finds something where nothing is. Then
//! false senders of several sizes, each in several drives, show whether and how soon they are found. All of
//! it is computed, in one process.

use frame::batch::{self, Done, Job};
use group::{Error, GroupOptions, ScenarioOptions};
use report::table::TextTable;
use serde::Serialize;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// The table of the controller's checks, which is no campaign of its own.
pub const NAME: &str = "plausibility";

/// Time without faults, s.
const QUIET_S: f64 = 36_000.0;
/// Drives with each fault.
const DRIVES: u32 = 20;
/// Scenarios with their lengths, s: radars of both models, cars and a truck, with signals and without.
const SCENARIOS: [(&str, f64); 6] = [
    ("following", 60.0),
    ("cut-in", 30.0),
    ("stop-and-go", 100.0),
    ("corridor", 130.0),
    ("cacc-a", 30.0),
    ("truck-follow", 160.0),
];
/// A fault: what it is, its size, the scenario, the keys, and when it begins, s, at the earliest and latest.
type Case = (&'static str, &'static str, &'static str, &'static str, f64, f64);

const FREEZE: &str = "kind = \"freeze\", for_s = 10, topic = ";
const BIAS: &str = "kind = \"bias\", for_s = 10, topic = ";

/// The false senders.
const CASES: [Case; 20] = [
    ("odometry frozen", "driving", "following", "\"vehicle/odometry\"", 5.0, 40.0),
    ("odometry frozen", "standing", "stop-and-go", "\"vehicle/odometry\"", 13.0, 17.0),
    (
        "speed biased",
        "+0.3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 0.3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+1 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 1",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "-3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = -3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "-5 m/s",
        "corridor",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = -5",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+5 m/s, truck",
        "truck-follow",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 5",
        5.0,
        40.0,
    ),
    ("radar frozen", "following", "following", "\"radar/tracks\"", 5.0, 40.0),
    ("radar frozen", "stop-and-go", "stop-and-go", "\"radar/tracks\"", 5.0, 80.0),
    ("radar frozen", "object list", "truck-follow", "\"radar/tracks\"", 5.0, 80.0),
    (
        "gap biased",
        "+2 m",
        "stop-and-go",
        "\"radar/tracks\", field = \"gap_m\", amount = 2",
        5.0,
        80.0,
    ),
    (
        "gap biased",
        "+5 m",
        "stop-and-go",
        "\"radar/tracks\", field = \"gap_m\", amount = 5",
        5.0,
        80.0,
    ),
    (
        "gap biased",
        "-5 m",
        "following",
        "\"radar/tracks\", field = \"gap_m\", amount = -5",
        5.0,
        40.0,
    ),
    (
        "relative speed biased",
        "+1 m/s",
        "stop-and-go",
        "\"radar/tracks\", field = \"relative_speed_mps\", amount = 1",
        5.0,
        80.0,
    ),
    (
        "relative speed biased",
        "+3 m/s",
        "stop-and-go",
        "\"radar/tracks\", field = \"relative_speed_mps\", amount = 3",
        5.0,
        80.0,
    ),
    (
        "countdown biased",
        "-0.5 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = -0.5",
        5.0,
        90.0,
    ),
    (
        "countdown biased",
        "-2 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = -2",
        5.0,
        90.0,
    ),
    (
        "countdown biased",
        "+2 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = 2",
        5.0,
        90.0,
    ),
    ("countdown frozen", "", "corridor", "\"v2x/spat\"", 5.0, 90.0),
];

/// What a check found without faults.
#[derive(Clone, Debug, Default, Serialize)]
struct Quiet {
    /// Cycles with a false alarm.
    false_alarms: u64,
    /// Largest value as a share of the threshold.
    nearest: f64,
    /// Where that was.
    scenario: String,
}

/// What was found of a false sender.
#[derive(Clone, Debug, Serialize)]
struct Found {
    fault: &'static str,
    size: &'static str,
    scenario: &'static str,
    drives: usize,
    found: usize,
    /// Checks that found it first, and in how many drives.
    checks: BTreeMap<String, usize>,
    /// Times from the fault's beginning until a check found it, s, in order.
    after_s: Vec<f64>,
}

/// The whole table.
#[derive(Clone, Debug, Serialize)]
struct Table {
    schema_version: u32,
    /// No check found something where nothing was.
    ok: bool,
    quiet_s: f64,
    drives: usize,
    checks: BTreeMap<String, Quiet>,
    faults: Vec<Found>,
}

/// Runs the drives and prints the table. Fails if a check found something where nothing was.
///
/// # Errors
/// As a campaign's runs.
pub fn run(
    group: &GroupOptions,
    jobs: Option<NonZeroUsize>,
    json: bool,
) -> Result<ExitCode, Error> {
    let mut table = Table {
        schema_version: 1,
        ok: false,
        quiet_s: 0.0,
        drives: 0,
        checks: BTreeMap::new(),
        faults: Vec::new(),
    };
    let at_once = batch::at_once(jobs, runtime::Mode::Lockstep);
    let mut planned: Vec<(Option<usize>, f64, Job)> = Vec::new();
    let whole_s: f64 = SCENARIOS.iter().map(|(_, length_s)| length_s).sum();
    for seed in 1..=(QUIET_S / whole_s).ceil() as u32 {
        for (scenario, length_s) in SCENARIOS {
            planned.push((None, 0.0, job(scenario, seed, length_s, None)?));
        }
    }
    for (index, case) in CASES.into_iter().enumerate() {
        let (_, size, scenario, keys, from_s, to_s) = case;
        table.faults.push(Found {
            fault: case.0,
            size,
            scenario,
            drives: 0,
            found: 0,
            checks: BTreeMap::new(),
            after_s: Vec::new(),
        });
        let kind = if keys.contains("field") { BIAS } else { FREEZE };
        for drive in 0..DRIVES {
            let at_s = from_s + (to_s - from_s) * f64::from(drive) / f64::from(DRIVES - 1);
            let at_s = (at_s * 100.0).round() / 100.0;
            let fault = format!("faults=[{{ {kind}{keys}, at_s = {at_s:.2} }}]");
            planned.push((Some(index), at_s, job(scenario, drive + 1, at_s + 12.0, Some(fault))?));
        }
    }
    let bar = report::progress::count_bar(planned.len(), json);
    let runs: Vec<Job> = planned.iter().map(|(_, _, job)| job.clone()).collect();
    let none = std::collections::BTreeSet::new();
    let end = batch::run_repeating(&none, &runs, at_once, group, &bar, &mut |index, result| {
        let (case, at_s, job) = &planned[index];
        let done = result?;
        match case {
            None => table.quiet(job, &done),
            Some(case) => table.faults[*case].take(*at_s, &done),
        }
        Ok(())
    });
    bar.finish_and_clear();
    end?;
    for found in &mut table.faults {
        found.after_s.sort_by(f64::total_cmp);
    }
    table.ok = table.checks.values().all(|check| check.false_alarms == 0);
    if json {
        let text = serde_json::to_string_pretty(&table).expect("plain data") + "\n";
        report::print::out(&text)?;
    } else {
        report::print::out(&table.text())?;
    }
    Ok(if table.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn job(name: &str, seed: u32, length_s: f64, fault: Option<String>) -> Result<Job, Error> {
    let options = ScenarioOptions { seed: Some(seed.to_string()), ..ScenarioOptions::default() };
    let keys: Vec<String> =
        std::iter::once(format!("duration_s={length_s:.2}")).chain(fault).collect();
    Ok(Job::lockstep(group::open_with(name, &options, "set", &keys)?))
}

impl Table {
    fn quiet(&mut self, job: &Job, done: &Done) {
        self.drives += 1;
        self.quiet_s += done.summary.duration_s;
        for check in &done.summary.checks {
            let quiet = self.checks.entry(check.check.clone()).or_default();
            quiet.false_alarms += check.cycles;
            if check.nearest > quiet.nearest {
                quiet.nearest = check.nearest;
                quiet.scenario = job.scenario.name.as_str().into();
            }
        }
    }

    fn text(&self) -> String {
        let hours = self.quiet_s / 3600.0;
        let mut text = format!("{hours:.1} h without faults, {} drives\n", self.drives);
        let mut checks =
            TextTable::of_figures(["check", "false alarms", "nearest to the threshold", "in"]);
        for (name, quiet) in &self.checks {
            checks.row([
                name.clone(),
                quiet.false_alarms.to_string(),
                format!("{:.0} %", 100.0 * quiet.nearest),
                quiet.scenario.clone(),
            ]);
        }
        text += &checks.text();
        text += "\nfalse senders, for 10 s\n";
        let mut faults = TextTable::of_figures([
            "fault",
            "size",
            "scenario",
            "found",
            "median",
            "longest",
            "first found by",
        ]);
        for found in &self.faults {
            let after = |place: usize| {
                found.after_s.get(place).map_or_else(|| "-".into(), |s| format!("{s:.2} s"))
            };
            let by: Vec<String> =
                found.checks.iter().map(|(check, count)| format!("{check} {count}")).collect();
            faults.row([
                found.fault.into(),
                found.size.into(),
                found.scenario.into(),
                format!("{} of {}", found.found, found.drives),
                after(found.after_s.len() / 2),
                after(found.after_s.len().saturating_sub(1)),
                by.join(", "),
            ]);
        }
        text + &faults.text()
    }
}

impl Found {
    fn take(&mut self, at_s: f64, done: &Done) {
        self.drives += 1;
        let alarms = done.summary.checks.iter().filter_map(|check| {
            check.first_s.filter(|first_s| *first_s >= at_s).map(|first_s| (first_s, &check.check))
        });
        if let Some((first_s, check)) = alarms.min_by(|a, b| a.0.total_cmp(&b.0)) {
            self.found += 1;
            self.after_s.push(first_s - at_s);
            *self.checks.entry(check.clone()).or_insert(0) += 1;
        }
    }
}
