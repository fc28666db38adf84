//! Recorded against replayed, message by message.

use super::Programs;
use group::Replayed;
use messages::{Command, Message, Place};
use recorder::{Recording, Take};
use runtime::{Mode, Program};
use scenario::Scenario;
use serde::Serialize;

/// Fields that say how the machine fared when a command was computed.
const MACHINE: [&str; 7] = [
    "header.protection",
    "header.publish_ns",
    "idle_ns",
    "voluntary_switches",
    "involuntary_switches",
    "minor_faults",
    "major_faults",
];

/// What both controllers asked for in one cycle.
pub(super) struct Row {
    pub(super) incarnation: u32,
    pub(super) step: u64,
    pub(super) time_s: f64,
    pub(super) recorded_mps2: f64,
    pub(super) replayed_mps2: f64,
}

impl Row {
    pub(super) fn new(recorded: &Command, replayed: &Command) -> Self {
        Self {
            incarnation: recorded.header.incarnation,
            step: recorded.header.step,
            time_s: recorded.header.acquisition_ns as f64 / 1e9,
            recorded_mps2: recorded.plan_mps2[0],
            replayed_mps2: replayed.plan_mps2[0],
        }
    }

    pub(super) fn difference_mps2(&self) -> f64 {
        self.replayed_mps2 - self.recorded_mps2
    }
}

/// What a replay found.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    pub(super) schema_version: u32,
    pub(super) scenario: String,
    pub(super) recorded_controller: String,
    pub(super) replayed_controller: String,
    /// The programs of the user's that drove; null where timegap's own controller did.
    pub(super) recorded_program: Option<Program>,
    pub(super) replayed_program: Option<Program>,
    /// The recorded run's clock.
    pub(super) mode: &'static str,
    /// True if the scenario was changed for the replay.
    pub(super) changed: bool,
    /// Fields that are not compared.
    pub(super) not_compared: Vec<&'static str>,
    /// Cycles replayed.
    pub(super) cycles: u64,
    /// Commands among them: in a silent cycle there is none.
    pub(super) commands: u64,
    /// Cycles that could not be replayed, and why.
    pub(super) cut_short: Vec<String>,
    /// Commands, and diagnostics, in which every compared byte is the same.
    pub(super) identical_commands: u64,
    pub(super) identical_diagnostics: u64,
    /// True if all are.
    pub(super) identical: bool,
    pub(super) first_difference: Option<Difference>,
    /// Largest and root-mean-square difference of the first requests, m/s².
    pub(super) max_request_difference_mps2: f64,
    pub(super) rms_request_difference_mps2: f64,
    /// When the largest was, s of run time.
    pub(super) max_request_difference_at_s: f64,
}

/// The first difference.
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
            not_compared: match metadata.mode {
                Mode::Lockstep => Vec::new(),
                Mode::Realtime => MACHINE.to_vec(),
            },
            cycles: 0,
            commands: 0,
            cut_short: Vec::new(),
            identical_commands: 0,
            identical_diagnostics: 0,
            identical: false,
            first_difference: None,
            max_request_difference_mps2: 0.0,
            rms_request_difference_mps2: 0.0,
            max_request_difference_at_s: 0.0,
        }
    }

    pub(super) fn add(&mut self, take: &Take, replayed: &Replayed) {
        self.cycles += take.releases.len() as u64;
        self.commands += take.commands.len().max(replayed.commands.len()) as u64;
        self.identical_commands += self.compare(by_step(&take.commands, &replayed.commands));
        self.identical_diagnostics +=
            self.compare(by_step(&take.diagnostics, &replayed.diagnostics));
        self.cut_short.extend(take.cut_short.clone());
    }

    /// Counts the pairs in which every compared byte is the same; keeps the first other one.
    fn compare<'a, T: Message>(&mut self, pairs: impl Iterator<Item = (&'a T, &'a T)>) -> u64 {
        let mut places = T::LAYOUT.scalars();
        places.retain(|place| !self.not_compared.iter().any(|field| place.path.starts_with(field)));
        let mut identical = 0;
        for (recorded, replayed) in pairs {
            let [a, b] = [recorded, replayed].map(bytemuck::bytes_of);
            let differs = |place: &&Place| {
                let range = place.offset..place.offset + place.bytes;
                a[range.clone()] != b[range]
            };
            let header = recorded.header();
            // The checksum differs whenever something else does.
            let telling = places
                .iter()
                .find(|place| differs(place) && !place.path.starts_with("header.protection"));
            match telling.or_else(|| places.iter().find(differs)) {
                None => identical += 1,
                Some(place) if self.first_difference.is_none() => {
                    self.first_difference = Some(Difference {
                        topic: T::TOPIC.name(),
                        incarnation: header.incarnation,
                        sequence: header.sequence,
                        step: header.step,
                        field: place.path.clone(),
                        recorded: place.read(a).to_string(),
                        replayed: place.read(b).to_string(),
                    });
                }
                Some(_) => {}
            }
        }
        identical
    }

    pub(super) fn finish(&mut self, rows: &[Row]) {
        self.identical =
            self.identical_commands == self.commands && self.identical_diagnostics == self.cycles;
        let squares: f64 = rows.iter().map(|row| row.difference_mps2().powi(2)).sum();
        self.rms_request_difference_mps2 = (squares / rows.len().max(1) as f64).sqrt();
        let size = |row: &&Row| row.difference_mps2().abs();
        if let Some(worst) = rows.iter().max_by(|a, b| size(a).total_cmp(&size(b))) {
            self.max_request_difference_mps2 = size(&worst);
            self.max_request_difference_at_s = worst.time_s;
        }
    }
}

/// Pairs of messages of the same cycle.
pub(super) fn by_step<'a, T: Message>(
    a: &'a [T],
    b: &'a [T],
) -> impl Iterator<Item = (&'a T, &'a T)> {
    let step = |message: &T| message.header().step;
    a.iter().filter_map(move |a| {
        // One process sends in the order of its steps.
        let index = b.binary_search_by_key(&step(a), step).ok()?;
        Some((a, &b[index]))
    })
}
