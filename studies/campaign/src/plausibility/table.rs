//! The table: false alarms by check and by kind of drive, and what was found of false senders.

use super::cases::CASES;
use super::draw::KINDS;
use super::rate::poisson;
use frame::batch::{Done, Job};
use report::table::TextTable;
use serde::Serialize;
use std::collections::BTreeMap;

/// Drives with a false alarm, in a time without faults.
#[derive(Clone, Debug, Default, Serialize)]
struct Rate {
    drives: u64,
    hours: f64,
    /// Drives with at least one false alarm.
    alarmed: u64,
    /// Those of them per hour, with the exact 95 % interval of a Poisson count.
    per_hour: f64,
    per_hour_ci95: [f64; 2],
}

impl Rate {
    fn add(&mut self, hours: f64, is_alarmed: bool) {
        self.drives += 1;
        self.hours += hours;
        self.alarmed += u64::from(is_alarmed);
    }

    fn finish(&mut self) {
        let hours = self.hours.max(f64::MIN_POSITIVE);
        self.per_hour = self.alarmed as f64 / hours;
        self.per_hour_ci95 = poisson(self.alarmed).map(|limit| limit / hours);
    }

    /// The rate and its interval, in two cells.
    fn cells(&self) -> [String; 2] {
        let [low, high] = self.per_hour_ci95;
        [format!("{:.2}", self.per_hour), format!("{low:.2} to {high:.2}")]
    }
}

/// What a check found without faults.
#[derive(Clone, Debug, Default, Serialize)]
struct Check {
    /// Cycles with a false alarm.
    false_alarms: u64,
    #[serde(flatten)]
    rate: Rate,
    /// Drives with a false alarm, by kind.
    kinds: BTreeMap<&'static str, u64>,
    /// A drive with a false alarm.
    example: Option<String>,
    /// Largest value without an alarm, as a share of the threshold.
    nearest: f64,
    /// The drive with that value.
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
pub struct Table {
    schema_version: u32,
    /// No check found something where nothing was.
    pub ok: bool,
    seed: u32,
    quiet_s: f64,
    drives: u64,
    /// All checks together.
    all: Rate,
    checks: BTreeMap<String, Check>,
    kinds: BTreeMap<&'static str, Rate>,
    faults: Vec<Found>,
}

impl Table {
    /// A table without a drive.
    pub fn new(seed: u32) -> Self {
        let faults = CASES.map(|(fault, size, scenario, ..)| Found {
            fault,
            size,
            scenario,
            drives: 0,
            found: 0,
            checks: BTreeMap::new(),
            after_s: Vec::new(),
        });
        Self {
            schema_version: 1,
            ok: false,
            seed,
            quiet_s: 0.0,
            drives: 0,
            all: Rate::default(),
            checks: BTreeMap::new(),
            kinds: BTreeMap::new(),
            faults: faults.into(),
        }
    }

    /// Adds a drive without faults.
    pub fn quiet(&mut self, kind: &'static str, job: &Job, done: &Done) {
        let name = job.scenario.name.as_str();
        let hours = done.summary.duration_s / 3600.0;
        self.drives += 1;
        self.quiet_s += done.summary.duration_s;
        for found in &done.summary.checks {
            let check = self.checks.entry(found.check.clone()).or_default();
            let is_alarmed = found.cycles > 0;
            check.false_alarms += found.cycles;
            check.rate.add(hours, is_alarmed);
            if is_alarmed {
                *check.kinds.entry(kind).or_default() += 1;
                check.example.get_or_insert_with(|| name.to_owned());
            }
            if found.nearest > check.nearest {
                check.nearest = found.nearest;
                check.scenario = name.to_owned();
            }
        }
        let is_alarmed = done.summary.checks.iter().any(|found| found.cycles > 0);
        self.all.add(hours, is_alarmed);
        self.kinds.entry(kind).or_default().add(hours, is_alarmed);
    }

    /// Adds a drive with the false sender of a case, which begins at `at_s`.
    pub fn faulty(&mut self, case: usize, at_s: f64, done: &Done) {
        let found = &mut self.faults[case];
        found.drives += 1;
        let alarms = done.summary.checks.iter().filter_map(|check| {
            check.first_s.filter(|first_s| *first_s >= at_s).map(|first_s| (first_s, &check.check))
        });
        if let Some((first_s, check)) = alarms.min_by(|a, b| a.0.total_cmp(&b.0)) {
            found.found += 1;
            found.after_s.push(first_s - at_s);
            *found.checks.entry(check.clone()).or_insert(0) += 1;
        }
    }

    /// Computes the rates, once all drives are there.
    pub fn finish(&mut self) {
        for found in &mut self.faults {
            found.after_s.sort_by(f64::total_cmp);
        }
        let rates = self.checks.values_mut().map(|check| &mut check.rate);
        rates.chain(self.kinds.values_mut()).chain([&mut self.all]).for_each(Rate::finish);
        self.ok = self.all.alarmed == 0;
    }

    /// For a terminal.
    pub fn text(&self) -> String {
        let [rate, interval] = self.all.cells();
        let mut text = format!(
            "{:.1} h without faults, {} drives from seed {}: {} with a false alarm, {rate} per hour (95 %: {interval})\n",
            self.all.hours, self.drives, self.seed, self.all.alarmed
        );
        let mut checks =
            TextTable::of_figures(["check", "alarmed", "per hour", "95 %", "nearest", "in"]);
        for (name, check) in &self.checks {
            let [rate, interval] = check.rate.cells();
            let nearest = format!("{:.0} %", 100.0 * check.nearest);
            let alarmed = check.rate.alarmed.to_string();
            let example = check.example.as_ref().unwrap_or(&check.scenario).clone();
            checks.row([name.clone(), alarmed, rate, interval, nearest, example]);
        }
        text += &checks.text();
        text += "\nfalse alarms by kind of drive\n";
        let mut kinds =
            TextTable::of_figures(["kind", "drives", "hours", "alarmed", "per hour", "95 %"]);
        for (kind, _) in KINDS {
            let Some(of) = self.kinds.get(kind) else { continue };
            let [rate, interval] = of.cells();
            let hours = format!("{:.2}", of.hours);
            kinds.row([
                kind.into(),
                of.drives.to_string(),
                hours,
                of.alarmed.to_string(),
                rate,
                interval,
            ]);
        }
        text += &kinds.text();
        text + "\nfalse senders, for 10 s\n" + &self.found()
    }

    fn found(&self) -> String {
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
        faults.text()
    }
}
