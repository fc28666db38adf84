//! Sums over all drives: false alarms by check and by kind of drive, and the false senders that were found.

use std::collections::BTreeMap;

use report::verdicts::Least;
use serde::Serialize;

use super::Kept;
use super::cases::CASES;

/// Probability outside the interval of a rate.
const TAILS: f64 = 0.05;

/// Rate of drives with a false alarm, in a time without faults.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Rate {
    /// Drives.
    pub drives: u64,
    /// Time that was driven.
    pub hours: f64,
    /// Drives with at least one false alarm.
    pub alarmed: u64,
    /// Their number per hour.
    pub per_hour: f64,
    /// Exact 95 % interval of it, as of a Poisson count.
    pub per_hour_ci95: [f64; 2],
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
        self.per_hour_ci95 =
            statistics::poisson_interval(self.alarmed, TAILS).map(|limit| limit / hours);
    }
}

/// Findings of a check without faults.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Check {
    /// Cycles with a false alarm.
    false_alarms: u64,
    /// Rate of drives with one.
    #[serde(flatten)]
    pub rate: Rate,
    /// Drives with a false alarm, by kind.
    kinds: BTreeMap<&'static str, u64>,
    /// A drive with a false alarm.
    pub example: Option<String>,
    /// Largest value without an alarm, as a share of the threshold.
    pub nearest: f64,
    /// The drive with that value.
    pub scenario: String,
}

/// Detections of a false sender.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// The fault.
    pub fault: &'static str,
    /// Its size.
    pub size: &'static str,
    /// The scenario.
    pub scenario: &'static str,
    /// Drives with it.
    pub drives: usize,
    /// Drives in which a check found it.
    pub found: usize,
    /// Number of drives by the check that found it first.
    pub checks: BTreeMap<String, usize>,
    /// Times from the fault's beginning until a check found it, s, in order.
    pub after_s: Vec<f64>,
}

/// The whole result.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    schema_version: u32,
    /// No check found a contradiction without a fault, and no drive broke a requirement.
    pub ok: bool,
    /// Seed of the random drives.
    pub seed: u32,
    /// The law of the user's own that drove the cars; null: those of the drives.
    pub law: Option<String>,
    quiet_s: f64,
    /// Random drives.
    pub drives: u64,
    /// All checks together.
    pub all: Rate,
    /// Each check by its name.
    pub checks: BTreeMap<String, Check>,
    /// Each kind of drive by its name.
    pub kinds: BTreeMap<&'static str, Rate>,
    /// The false senders.
    pub faults: Vec<Found>,
    /// Requirements of the command: their least margins over all drives.
    pub margins: Vec<Least>,
}

impl Results {
    /// The result without a drive.
    pub fn new(seed: u32, law: Option<&str>) -> Self {
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
            law: law.map(str::to_owned),
            quiet_s: 0.0,
            drives: 0,
            all: Rate::default(),
            checks: BTreeMap::new(),
            kinds: BTreeMap::new(),
            faults: faults.into(),
            margins: Vec::new(),
        }
    }

    /// Adds a drive without faults.
    pub fn quiet(&mut self, kind: &'static str, kept: &Kept) {
        let name = &kept.scenario;
        let hours = kept.duration_s / 3600.0;
        self.drives += 1;
        self.quiet_s += kept.duration_s;
        for found in &kept.checks {
            let check = self.checks.entry(found.check.clone()).or_default();
            let is_alarmed = found.cycles > 0;
            check.false_alarms += found.cycles;
            check.rate.add(hours, is_alarmed);
            if is_alarmed {
                *check.kinds.entry(kind).or_default() += 1;
                check.example.get_or_insert_with(|| name.clone());
            }
            if found.nearest > check.nearest {
                check.nearest = found.nearest;
                check.scenario = name.clone();
            }
        }
        let is_alarmed = kept.checks.iter().any(|found| found.cycles > 0);
        self.all.add(hours, is_alarmed);
        self.kinds.entry(kind).or_default().add(hours, is_alarmed);
    }

    /// Adds a drive with the false sender of a case, which begins at `at_s`.
    pub fn faulty(&mut self, case: usize, at_s: f64, kept: &Kept) {
        let found = &mut self.faults[case];
        found.drives += 1;
        let alarms = kept.checks.iter().filter_map(|check| {
            check.first_s.filter(|first_s| *first_s >= at_s).map(|first_s| (first_s, &check.check))
        });
        if let Some((first_s, check)) = alarms.min_by(|a, b| a.0.total_cmp(&b.0)) {
            found.found += 1;
            found.after_s.push(first_s - at_s);
            *found.checks.entry(check.clone()).or_insert(0) += 1;
        }
    }

    /// Computes the rates when all drives are there.
    pub fn finish(&mut self) {
        for found in &mut self.faults {
            found.after_s.sort_by(f64::total_cmp);
        }
        let rates = self.checks.values_mut().map(|check| &mut check.rate);
        rates.chain(self.kinds.values_mut()).chain([&mut self.all]).for_each(Rate::finish);
        self.ok = self.all.alarmed == 0;
    }

    /// Adds the margins of the requirements.
    pub fn require(&mut self, margins: Vec<Least>) {
        self.ok &= margins.iter().all(|least| least.verdict.met);
        self.margins = margins;
    }
}
