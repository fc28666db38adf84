//! `timegap campaign radio`: drives through signals whose frames are lost, late and falsified.
//!
//! Each run is `corridor` with its own signal programs and its own things wrong with the air, the roadside
//! units and the on-board unit, drawn from a generator that the run's number seeds. No run may cross a red
//! light. What no receiver without signatures can tell is left out: a unit that is wrong from the first frame
//! on and that no other one contradicts.

use crate::batch::{self, Done, Job};
use group::{Error, GroupOptions, ScenarioOptions};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use report::table::TextTable;
use runtime::report::Outcome;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Runs where nothing else is asked for.
const RUNS: usize = 2_000;
const SCENARIO: &str = "corridor";
/// Keys that a run has always, with their largest values; each is drawn in one run of three.
const AIR: [(&str, f64); 10] = [
    ("v2x.air.loss_probability", 0.5),
    ("v2x.air.burst_begin_probability", 0.1),
    ("v2x.air.delay_ms", 400.0),
    ("v2x.air.jitter_ms", 300.0),
    ("v2x.air.reorder_probability", 0.3),
    ("v2x.air.duplicate_probability", 0.5),
    ("v2x.air.truncate_probability", 0.3),
    ("v2x.air.bit_flip_probability", 0.2),
    ("v2x.air.replay_probability", 0.3),
    ("v2x.air.replay_age_s", 60.0),
];
/// Offsets of clocks, ms, and drifts, millionths.
const CLOCKS: [(&str, f64); 4] = [
    ("v2x.unit.clock_offset_ms", 100.0),
    ("v2x.unit.clock_drift_ppm", 100.0),
    ("v2x.obu.clock_offset_ms", 100.0),
    ("v2x.obu.clock_drift_ppm", 100.0),
];

/// What came of all runs.
#[derive(Clone, Debug, Default, Serialize)]
struct Table {
    runs: usize,
    outcomes: BTreeMap<String, usize>,
    /// Run numbers that crossed a red light or touched another vehicle.
    violations: Vec<usize>,
    frames: u64,
    verdicts: BTreeMap<String, u64>,
    /// Time that the controller was without its signals, s, over all runs.
    signals_lost_s: f64,
    driven_s: f64,
}

/// Runs the drives and prints what came of them. Fails if one crossed a red light or ended in a collision.
///
/// # Errors
/// As a campaign's runs.
pub fn run(
    group: &GroupOptions,
    runs: Option<NonZeroUsize>,
    jobs: Option<NonZeroUsize>,
    json: bool,
) -> Result<ExitCode, Error> {
    let count = runs.map_or(RUNS, NonZeroUsize::get);
    let planned: Vec<Job> = (1..=count).map(job).collect::<Result<_, _>>()?;
    let bar = report::progress::count_bar(count, json);
    let at_once = batch::at_once(jobs, runtime::Mode::Lockstep);
    let none = BTreeSet::new();
    let mut table = Table::default();
    let end = batch::run_repeating(&none, &planned, at_once, group, &bar, &mut |index, result| {
        table.take(index + 1, &result?);
        Ok(())
    });
    bar.finish_and_clear();
    end?;
    table.violations.sort_unstable();
    if json {
        report::print::out(&(serde_json::to_string_pretty(&table).expect("plain data") + "\n"))?;
    } else {
        report::print::out(&table.text())?;
    }
    Ok(if table.violations.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Run `number`, counted from 1.
fn job(number: usize) -> Result<Job, Error> {
    let options = ScenarioOptions { seed: Some(number.to_string()), ..ScenarioOptions::default() };
    Ok(Job::lockstep(group::open_with(SCENARIO, &options, "set", &keys(number as u64))?))
}

/// What is different in run `number`.
fn keys(number: u64) -> Vec<String> {
    let mut generator = Pcg64::seed_from_u64(number);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random::uniform(&mut generator);
    let mut keys = Vec::new();
    for signal in 0..3 {
        keys.push(format!("v2x.signals.{signal}.offset_s={:.1}", uniform(0.0, 60.0)));
    }
    // Where the air is bad from: never before the vehicle can have heard of the first signal.
    keys.push(format!("v2x.air.from_s={:.1}", uniform(2.0, 60.0)));
    if uniform(0.0, 1.0) < 0.5 {
        keys.push(format!("v2x.air.for_s={:.1}", uniform(1.0, 60.0)));
    }
    for (key, most) in AIR {
        let (is_drawn, value) = (uniform(0.0, 3.0) < 1.0, uniform(0.0, most));
        let value = if key.ends_with("_ms") { value.round() } else { value };
        if is_drawn {
            keys.push(format!("{key}={value}"));
        }
    }
    for (key, most) in CLOCKS {
        keys.push(format!("{key}={}", uniform(-most, most).round()));
    }
    let (wrong, at_s) = (uniform(0.0, 8.0), uniform(5.0, 90.0));
    let (jump_s, slide, shift_m) = (uniform(0.0, 5.0), uniform(0.0, 1.0), uniform(-20.0, 0.0));
    match wrong as u32 {
        0 => keys.push(format!("v2x.unit.contradicted_from_s={at_s:.1}")),
        1 => {
            keys.push(format!("v2x.unit.map_changes_at_s={at_s:.1}"));
            keys.push(format!("v2x.unit.map_shift_m={shift_m:.1}"));
        }
        2 => {
            keys.push(format!("v2x.unit.countdown_wrong_from_s={at_s:.1}"));
            keys.push(format!("v2x.unit.countdown_jump_s={jump_s:.2}"));
        }
        3 => {
            keys.push(format!("v2x.unit.countdown_wrong_from_s={at_s:.1}"));
            keys.push(format!("v2x.unit.countdown_slide={slide:.3}"));
        }
        _ => {}
    }
    keys
}

impl Table {
    fn take(&mut self, number: usize, done: &Done) {
        let summary = &done.summary;
        self.runs += 1;
        self.driven_s += summary.duration_s;
        let outcome = report::print::outcome_word(summary.outcome).to_lowercase();
        *self.outcomes.entry(outcome).or_default() += 1;
        if summary.outcome != Outcome::Completed {
            self.violations.push(number);
        }
        if let Some(radio) = &summary.radio {
            self.frames += radio.frames;
            for (verdict, count) in &radio.verdicts {
                *self.verdicts.entry(verdict.clone()).or_default() += count;
            }
        }
        let levels = summary.rungs.get("controller").map(|levels| &levels.time_s);
        let lost_s = levels.and_then(|levels| levels.get("signals-lost"));
        self.signals_lost_s += lost_s.copied().unwrap_or(0.0);
    }

    fn text(&self) -> String {
        let outcomes: Vec<_> = self.outcomes.iter().map(|(o, n)| format!("{n} {o}")).collect();
        let mut text = format!(
            "{} runs of {SCENARIO}: {}\n{:.1} h driven, {:.1} % of it without signals\n",
            self.runs,
            outcomes.join(", "),
            self.driven_s / 3600.0,
            100.0 * self.signals_lost_s / self.driven_s.max(1.0)
        );
        if !self.violations.is_empty() {
            text += &format!("not completed: runs {:?}\n", self.violations);
        }
        let mut table = TextTable::of_figures(["frames", "", "share"]);
        for (verdict, count) in &self.verdicts {
            let share = 100.0 * *count as f64 / self.frames.max(1) as f64;
            table.row([verdict.replace('_', " "), count.to_string(), format!("{share:.2} %")]);
        }
        text + &table.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_a_scenario_and_its_number_makes_it() {
        for number in 1..=200 {
            job(number).unwrap_or_else(|error| panic!("run {number}: {error}"));
        }
        assert_eq!(keys(7), keys(7));
        assert_ne!(keys(7), keys(8));
    }
}
