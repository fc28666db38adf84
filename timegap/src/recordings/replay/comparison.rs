//! Recorded messages compared with replayed ones.

use super::{Programs, Table};
use crate::recordings::diff::first_difference;
use messages::{Command, Diagnostics, Header, Message, Place};
use recorder::{Cycle, Recording, Take};
use runtime::{Mode, Program};
use scenario::Scenario;
use serde::Serialize;
use std::collections::VecDeque;
use std::fmt;
use supervise::Replayed;

#[derive(Debug, Default, Serialize)]
pub(super) struct Comparison {
    pub(super) schema_version: u32,
    pub(super) scenario: String,
    pub(super) recorded_controller: String,
    pub(super) replayed_controller: String,
    /// The user's programs that drove; null for timegap's own controller.
    pub(super) recorded_program: Option<Program>,
    pub(super) replayed_program: Option<Program>,
    pub(super) mode: &'static str,
    pub(super) changed: bool,
    pub(super) not_compared: Vec<&'static str>,
    pub(super) cycles: u64,
    /// Replayed cycles with a command.
    pub(super) commands: u64,
    /// Reasons why cycles could not be replayed.
    pub(super) cut_short: Vec<String>,
    /// Commands and diagnostics that are equal in every compared byte.
    pub(super) identical_commands: u64,
    pub(super) identical_diagnostics: u64,
    pub(super) identical: bool,
    pub(super) first_difference: Option<Difference>,
    /// Largest and root-mean-square difference of the first requests, m/s².
    pub(super) max_request_difference_mps2: f64,
    pub(super) rms_request_difference_mps2: f64,
    /// Run time of the largest difference, s.
    pub(super) max_request_difference_at_s: f64,
    /// Pairs of requests, and the sum of their squared differences.
    #[serde(skip)]
    rows: u64,
    #[serde(skip)]
    squares: f64,
}

impl Comparison {
    pub(super) fn new(
        recording: &Recording,
        scenario: &Scenario,
        changed: bool,
        programs: Programs,
    ) -> Self {
        let metadata = recording.metadata();
        let driver = |law: &str, program: &Option<Program>| match program {
            Some(program) => program.name.clone(),
            None => law.to_owned(),
        };
        Self {
            schema_version: 1,
            scenario: metadata.scenario_name.clone(),
            recorded_controller: driver(&metadata.controller, &programs.recorded),
            replayed_controller: driver(scenario.controller.name.as_str(), &programs.replayed),
            recorded_program: programs.recorded,
            replayed_program: programs.replayed,
            mode: metadata.mode.name(),
            changed,
            not_compared: not_compared(metadata.mode),
            ..Self::default()
        }
    }

    /// True if every compared byte of the pair is equal; keeps the first difference.
    fn is_same<T: Message>(&mut self, places: &[Place], recorded: &T, replayed: &T) -> bool {
        let Some(difference) = Difference::between(places, recorded, replayed) else { return true };
        self.first_difference.get_or_insert(difference);
        false
    }

    /// Notes the first requests of both controllers in one cycle; returns their row of the table.
    fn note(&mut self, recorded: &Command, replayed: &Command) -> String {
        let [recorded_mps2, replayed_mps2] = [recorded, replayed].map(|of| of.plan_mps2[0]);
        let difference_mps2 = replayed_mps2 - recorded_mps2;
        let time_s = recorded.header.acquisition_ns as f64 / 1e9;
        self.rows += 1;
        self.squares += difference_mps2 * difference_mps2;
        if self.rows == 1 || difference_mps2.abs() > self.max_request_difference_mps2 {
            self.max_request_difference_mps2 = difference_mps2.abs();
            self.max_request_difference_at_s = time_s;
        }
        let Header { incarnation, step, .. } = recorded.header;
        format!("{incarnation},{step},{time_s},{recorded_mps2},{replayed_mps2},{difference_mps2}")
    }

    pub(super) fn finish(&mut self) {
        self.identical =
            self.identical_commands == self.commands && self.identical_diagnostics == self.cycles;
        self.rms_request_difference_mps2 = (self.squares / self.rows.max(1) as f64).sqrt();
    }
}

/// Recorded messages beside replayed ones during a replay.
pub(super) struct Pairs<'a, R: Iterator<Item = Cycle>> {
    /// Recorded cycles whose diagnostics were not replayed yet.
    recorded: R,
    waiting: VecDeque<Cycle>,
    commands: u64,
    comparison: &'a mut Comparison,
    table: &'a mut Table,
    places: [Vec<Place>; 2],
}

impl<'a, R: Iterator<Item = Cycle>> Pairs<'a, R> {
    pub(super) fn new(recorded: R, comparison: &'a mut Comparison, table: &'a mut Table) -> Self {
        let places = [
            places::<Command>(&comparison.not_compared),
            places::<Diagnostics>(&comparison.not_compared),
        ];
        Self { recorded, waiting: VecDeque::new(), commands: 0, comparison, table, places }
    }

    /// Compares replayed with recorded messages of the controller; returns the cycles up to here.
    pub(super) fn add(&mut self, said: Replayed<'_>) -> u64 {
        match said {
            Replayed::Command(replayed) => {
                self.commands += 1;
                let cycle = self.find(replayed.header.step);
                if let Some(recorded) = cycle.and_then(|cycle| cycle.command) {
                    let is_same = self.comparison.is_same(&self.places[0], &recorded, replayed);
                    self.comparison.identical_commands += u64::from(is_same);
                    self.table.add(&self.comparison.note(&recorded, replayed));
                }
            }
            Replayed::Diagnostics(replayed) => {
                self.comparison.cycles += 1;
                let step = replayed.header.step;
                if let Some(recorded) = self.find(step).map(|cycle| cycle.diagnostics) {
                    let is_same = self.comparison.is_same(&self.places[1], &recorded, replayed);
                    self.comparison.identical_diagnostics += u64::from(is_same);
                }
                // A listener reads commands before diagnostics, up to a buffer of cycles later.
                while self.waiting.len() > MOST_WAITING {
                    self.waiting.pop_front();
                }
            }
        }
        self.comparison.cycles
    }

    fn find(&mut self, step: u64) -> Option<&Cycle> {
        while self.waiting.back().is_none_or(|cycle| cycle.diagnostics.header.step < step) {
            self.waiting.push_back(self.recorded.next()?);
        }
        // One process proceeds in the order of its steps.
        let steps = self.waiting.make_contiguous();
        let index =
            steps.binary_search_by_key(&step, |cycle| cycle.diagnostics.header.step).ok()?;
        self.waiting.get(index)
    }

    /// Counts the messages that should have been replayed.
    pub(super) fn finish(self, take: &Take) {
        self.comparison.commands += take.commands.max(self.commands);
        self.comparison.cut_short.extend(take.cut_short.clone());
    }
}

/// Recorded cycles that are kept after their diagnostics were replayed.
const MOST_WAITING: usize = 256;

/// Fields about the machine's performance.
const MACHINE: [&str; 7] = [
    "header.protection",
    "header.publish_ns",
    "idle_ns",
    "voluntary_switches",
    "involuntary_switches",
    "minor_faults",
    "major_faults",
];

/// Fields that are not compared in a run with this clock.
pub(super) fn not_compared(mode: Mode) -> Vec<&'static str> {
    match mode {
        Mode::Lockstep => Vec::new(),
        Mode::Realtime => MACHINE.to_vec(),
    }
}

pub(super) fn places<T: Message>(not_compared: &[&str]) -> Vec<Place> {
    let mut places = T::LAYOUT.scalars();
    places.retain(|place| !not_compared.iter().any(|field| place.path.starts_with(field)));
    places
}

#[derive(Debug, Serialize)]
pub(super) struct Difference {
    pub(super) topic: &'static str,
    pub(super) incarnation: u32,
    pub(super) sequence: u64,
    pub(super) step: u64,
    pub(super) field: String,
    pub(super) recorded: String,
    pub(super) replayed: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { topic, sequence, field, recorded, replayed, .. } = self;
        write!(f, "{topic}, message {sequence}, {field}: {recorded} recorded, {replayed} replayed")
    }
}

impl Difference {
    /// The first of `places` whose bytes differ.
    pub(super) fn between<T: Message>(
        places: &[Place],
        recorded: &T,
        replayed: &T,
    ) -> Option<Self> {
        let [a, b] = [recorded, replayed].map(bytemuck::bytes_of);
        let header = recorded.header();
        let place = first_difference(places, a, b)?;
        Some(Self {
            topic: T::TOPIC.name(),
            incarnation: header.incarnation,
            sequence: header.sequence,
            step: header.step,
            field: place.path.clone(),
            recorded: place.read(a).to_string(),
            replayed: place.read(b).to_string(),
        })
    }
}
