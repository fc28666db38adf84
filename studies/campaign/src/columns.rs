//! The columns of a campaign's results: each figure is declared once. Below them stand the figures of each run, by which a
//! campaign is compared with an earlier one.

use super::blame::Broken;
use super::exposure::Exposure;
use super::measured::{self, LEFT_OUT};
use super::record::Record;
use super::sums;
use super::sums::Tally;
use super::verdict::{Requirement, Verdict};
use report::gate::Sample;
use report::results::{
    Column, Format, Good, Schema, column, count, fact, flag, micros, number, word,
};
use runtime::Mode;
use serde::Serialize;
use serde_json::{Value, json};
use supervise::report::Outcome;

/// The sums over some runs. The shown ones make a table of runs; `totals` has the others of all runs.
pub fn sums<R>() -> Vec<Column<R>> {
    let named = [word("memory_growth_of", "memory grew in", "The service that grew most").hidden()];
    let measured = measured::extreme_columns().into_iter().chain(measured::time_columns());
    sums::columns().into_iter().chain(measured).chain(named).collect()
}

pub const REQUIREMENTS: &[Column<Requirement>] = &[
    word("requirement", "requirement", "Key in the campaign's file"),
    column("limit", "limit", "", Format::Exact, "The limit of these runs"),
    column("found", "found", "", Format::Exact, "The value; null if no run measured it"),
    flag("ok", "", ("holds", "BROKEN"), "The value keeps the limit"),
];

/// Columns of the drives without faults.
pub const EXPOSURE: &[Column<Exposure>] = &[
    word("scenario", "scenario", "Scenario"),
    word("controller", "controller", "Control law"),
    number("hardest_braking_mps2", "hardest braking", "m/s²", 1, "Hardest braking"),
    number("min_ttc_s", "min TTC", "s", 1, "Least time to collision"),
    count("reds_met", "lights on red", "Signals that were red when the ego was near").weight(1),
    count("yellows_met", "on yellow", "Signals that were yellow when the ego was near").weight(2),
    count("standstills", "standstills", "Times that the ego came to a standstill").weight(2),
    number("standstill_s", "standing", "s", 0, "Time in standstill").weight(3),
    count("cut_ins", "cut-ins", "Times that a vehicle began to come into the lane").weight(1),
    number("cut_in_s", "", "s", 0, "Time with a vehicle on its way into the lane").hidden(),
    number("critical_share", "", "", 2, "Share of the drive in a critical phase").hidden(),
    number("", "critical", "%", 0, "").of(percent),
];

fn percent(met: &Exposure) -> Value {
    json!(100.0 * met.critical_share)
}

/// Columns of the runs to blame by scenario and fault.
pub const BROKEN: &[Column<Broken>] = &[
    word("scenario", "scenario", "Scenario"),
    word("fault", "fault", "Fault"),
    count("runs", "runs", "Runs to blame"),
];

/// Some runs with their sums, for people.
#[derive(Serialize)]
pub struct Line<'a> {
    /// The thing that they have in common; none in a table of combinations.
    pub by: Option<&'static str>,
    pub of: String,
    #[serde(flatten)]
    pub tally: &'a Tally,
}

pub fn lines<'a>() -> Vec<Column<Line<'a>>> {
    let names = [word("by", "", ""), word("of", "runs of", "Scenario, controller and fault")];
    let p99 = micros("", "recovery p99", "").weight(LEFT_OUT).of(|line: &Line<'_>| {
        json!(line.tally.measures.times.recovery_us.as_ref().and_then(report::print::p99))
    });
    names.into_iter().chain(sums()).chain([p99]).collect()
}

/// The campaign's own columns of `runs.csv`.
pub const RUNS: &[Column<Record>] = &[
    fact("avoidable", "avoidable", "It ended in a collision that a braking reference avoids"),
    count("kills", "kills", "Killed processes"),
    micros("max_detection_us", "detection", "Longest time until the launcher noticed")
        .of(detection),
    micros("max_recovery_us", "recovery", "Longest time until a first message").of(recovery),
    count("unrecovered", "unrecovered", "Process faults without a recovery"),
    count("messages_lost", "lost", "Lost messages"),
    count("disturbed", "disturbed", "Messages disturbed by faults"),
    count("corrupted", "corrupted", "Messages corrupted by faults"),
    count("undetected", "undetected", "Corrupted messages that were accepted"),
    count("leaks", "leaks", "Leftovers").of(leaks),
];

fn longest(times_us: &[f64]) -> Value {
    json!(times_us.iter().copied().max_by(f64::total_cmp))
}

fn detection(record: &Record) -> Value {
    longest(&record.measured.detection_us)
}

fn recovery(record: &Record) -> Value {
    longest(&record.measured.recovery_us)
}

fn leaks(record: &Record) -> Value {
    json!(record.measured.leaks.len())
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Verdict>("campaign")
}

/// The compared figures of a run.
pub struct Run {
    controller: String,
    values: [Option<f64>; 5],
}

/// Name, good values and least difference of each.
const FIGURES: [(&str, Good, f64); 5] = [
    ("completed", Good::More, 0.0),
    ("min_gap_m", Good::More, 0.005),
    ("min_ttc_s", Good::More, 0.005),
    ("interventions", Good::Less, 0.0),
    ("recovery_us", Good::Less, 0.5),
];

impl Run {
    pub fn of(record: &Record) -> Self {
        let measured = &record.measured;
        let completed = f64::from(u8::from(record.outcome == Outcome::Completed));
        let longest_us = measured.recovery_us.iter().copied().reduce(f64::max);
        let values = [
            Some(completed),
            measured.min_gap_m,
            measured.min_ttc_s,
            Some(measured.interventions as f64),
            longest_us,
        ];
        Self { controller: record.controller.clone(), values }
    }
}

/// The figures of all runs, law by law. In simulated time each run repeats exactly.
pub fn samples(runs: &[Run], mode: Mode) -> Vec<Sample> {
    let mut laws: Vec<&String> = runs.iter().map(|run| &run.controller).collect();
    laws.sort_unstable();
    laws.dedup();
    let of = |law: &String, place: usize| {
        let (figure, good, shown) = FIGURES[place];
        let own = runs.iter().filter(|run| run.controller == *law);
        let is_exact = mode == Mode::Lockstep && place == 0;
        let values = own.map(|run| run.values[place]).collect();
        Sample { of: law.clone(), figure: figure.to_owned(), values, good, shown, is_exact }
    };
    let all = laws.iter().flat_map(|law| (0..FIGURES.len()).map(|place| of(law, place)));
    all.filter(|sample| sample.values.iter().any(Option::is_some)).collect()
}
