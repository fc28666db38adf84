//! `timegap replay`: a recorded run's inputs into the controller again.
//!
//! The controller is the real process on real topics; a replayer stands for everybody else and sends
//! the recorded samples as they were. The controller is released as often as it was, at the recorded
//! instants, and takes at each release the very samples that its recorded diagnostics name, also
//! where it then kept silent. Each process of a controller that was restarted is replayed by itself.
//!
//! With the recorded controller the outputs must be the same. What is compared depends on the clock
//! that the run was recorded on. In lockstep it is every byte of every command and diagnostics
//! message. In realtime it is every byte but those that say how the machine fared: when the message
//! was published (and the checksum over it), since when the cycle had waited, and its context
//! switches and page faults. One thing is not in a recording: when a plan made beside the loop came.
//! In a replay every plan comes in time; a realtime run whose summary counts late plans may differ.

use super::{count, open};
use crate::error::Error;
use crate::group::{Replayed, replay};
use crate::print;
use crate::run::count_bar;
use clap::Args;
use controller::laws;
use recorder::{Recording, Take};
use serde::Serialize;
use shared::messages::{Command, Message, Place};
use shared::runtime::Mode;
use shared::scenario::{Overrides, Scenario};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// A run's directory of results, or a recording
    pub run: PathBuf,
    /// Give the inputs to another control law (see `timegap list`) and compare its commands
    #[arg(long, value_name = "NAME")]
    pub controller: Option<String>,
    /// Change any key of the recorded scenario, by its dotted path; may be given again
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Where to write both controllers' requests [default: replay.csv beside the recording]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print the comparison as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &ReplayArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let (scenario, changed) = scenario(&recording, arguments)?;
    let takes = recording.takes();
    let cycles: usize = takes.iter().map(|take| take.releases.len()).sum();
    if cycles == 0 {
        let path = recording.path().display();
        return Err(Error::Usage(format!("{path} holds no control cycle that could be replayed")));
    }
    let bar = count_bar(cycles, arguments.json);
    let mut done = 0;
    let mut rows = Vec::new();
    let mut comparison = Comparison::new(&recording, &scenario, changed);
    for take in &takes {
        let replayed = replay(&scenario, take, recording.path(), &mut |cycles| {
            bar.set_position(done + cycles);
        })?;
        done += take.releases.len() as u64;
        comparison.add(take, &replayed);
        rows.extend(by_step(&take.commands, &replayed.commands).map(|(a, b)| Row::new(a, b)));
    }
    bar.finish_and_clear();
    comparison.finish(&rows);

    let path =
        arguments.out.clone().unwrap_or_else(|| recording.path().with_file_name("replay.csv"));
    let written = write(&path, &rows);
    if arguments.json {
        print::out(&(serde_json::to_string_pretty(&comparison).expect("plain data") + "\n"));
    } else {
        print::out(&(as_text(&comparison) + &format!("  results        {}\n", path.display())));
    }
    written?;
    Ok(if changed || comparison.identical { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The recorded scenario, and whether something of it was changed.
fn scenario(recording: &Recording, arguments: &ReplayArguments) -> Result<(Scenario, bool), Error> {
    let usage = |error: &dyn std::fmt::Display| Error::Usage(error.to_string());
    let mut overrides = Overrides::new();
    if let Some(controller) = &arguments.controller {
        overrides.option("--controller", "controller.name", controller);
    }
    for argument in &arguments.set {
        overrides.set(argument).map_err(|e| usage(&e))?;
    }
    let text = &recording.metadata().scenario;
    let recorded = Scenario::parse("the recorded scenario", text).map_err(|e| usage(&e))?;
    let scenario = Scenario::parse_with("the recorded scenario", text, &overrides, &laws::check)
        .map_err(|e| usage(&e))?;
    let changed = scenario != recorded;
    Ok((scenario, changed))
}

/// Pairs of messages of the same cycle.
fn by_step<'a, T: Message>(a: &'a [T], b: &'a [T]) -> impl Iterator<Item = (&'a T, &'a T)> {
    let step = |message: &T| message.header().step;
    a.iter().filter_map(move |a| {
        // One process sends in the order of its steps.
        let index = b.binary_search_by_key(&step(a), step).ok()?;
        Some((a, &b[index]))
    })
}

/// What both controllers asked for in one cycle.
struct Row {
    incarnation: u32,
    step: u64,
    time_s: f64,
    recorded_mps2: f64,
    replayed_mps2: f64,
}

impl Row {
    fn new(recorded: &Command, replayed: &Command) -> Self {
        Self {
            incarnation: recorded.header.incarnation,
            step: recorded.header.step,
            time_s: recorded.header.acquisition_ns as f64 / 1e9,
            recorded_mps2: recorded.plan_mps2[0],
            replayed_mps2: replayed.plan_mps2[0],
        }
    }

    fn difference_mps2(&self) -> f64 {
        self.replayed_mps2 - self.recorded_mps2
    }
}

fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
    let mut text = String::from(
        "incarnation,step,time_s,recorded_request_mps2,replayed_request_mps2,difference_mps2\n",
    );
    for row in rows {
        writeln!(
            text,
            "{},{},{},{},{},{}",
            row.incarnation,
            row.step,
            row.time_s,
            row.recorded_mps2,
            row.replayed_mps2,
            row.difference_mps2()
        )
        .expect("a string takes all");
    }
    std::fs::write(path, text).map_err(|reason| Error::Path {
        action: "write",
        path: path.to_owned(),
        reason,
    })
}

/// What a replay found.
#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    scenario: String,
    recorded_controller: String,
    replayed_controller: String,
    /// The recorded run's clock.
    mode: &'static str,
    /// True if the scenario was changed for the replay.
    changed: bool,
    /// Fields that are not compared.
    not_compared: Vec<&'static str>,
    /// Cycles replayed.
    cycles: u64,
    /// Commands among them: in a silent cycle there is none.
    commands: u64,
    /// Cycles that could not be replayed, and why.
    cut_short: Vec<String>,
    /// Commands, and diagnostics, in which every compared byte is the same.
    identical_commands: u64,
    identical_diagnostics: u64,
    /// True if all are.
    identical: bool,
    first_difference: Option<Difference>,
    /// Largest and root-mean-square difference of the first requests, m/s².
    max_request_difference_mps2: f64,
    rms_request_difference_mps2: f64,
    /// When the largest was, s of run time.
    max_request_difference_at_s: f64,
}

/// The first difference.
#[derive(Debug, Serialize)]
struct Difference {
    topic: &'static str,
    incarnation: u32,
    sequence: u64,
    step: u64,
    field: String,
    recorded: String,
    replayed: String,
}

impl Comparison {
    fn new(recording: &Recording, scenario: &Scenario, changed: bool) -> Self {
        let metadata = recording.metadata();
        Self {
            schema_version: 1,
            scenario: metadata.scenario_name.clone(),
            recorded_controller: metadata.controller.clone(),
            replayed_controller: scenario.controller.name.as_str().into(),
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

    fn add(&mut self, take: &Take, replayed: &Replayed) {
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

    fn finish(&mut self, rows: &[Row]) {
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

fn as_text(comparison: &Comparison) -> String {
    let c = comparison;
    let laws = if c.recorded_controller == c.replayed_controller {
        c.recorded_controller.clone()
    } else {
        format!("{} recorded, {} replayed", c.recorded_controller, c.replayed_controller)
    };
    let mut text = format!("{} · {laws} · {}\n", c.scenario, c.mode);
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<14} {value}").expect("a string takes all");
    };
    line("replayed", count(c.cycles, "control cycle"));
    for why in &c.cut_short {
        line("CUT SHORT", why.clone());
    }
    if !c.changed {
        let same = |identical: u64, all: u64| match identical == all {
            true => format!("all {all} byte-identical"),
            false => format!("ONLY {identical} of {all} BYTE-IDENTICAL"),
        };
        line("commands", same(c.identical_commands, c.commands));
        line("diagnostics", same(c.identical_diagnostics, c.cycles));
        if !c.not_compared.is_empty() {
            line("", format!("not compared: {}", c.not_compared.join(", ")));
        }
    }
    if !c.identical {
        line(
            "requests",
            format!(
                "differ by at most {:.3} m/s², at {:.2} s; root mean square {:.3} m/s²",
                c.max_request_difference_mps2,
                c.max_request_difference_at_s,
                c.rms_request_difference_mps2
            ),
        );
        if let Some(first) = &c.first_difference {
            line(
                "first",
                format!(
                    "{}, message {}, {}: {} recorded, {} replayed",
                    first.topic, first.sequence, first.field, first.recorded, first.replayed
                ),
            );
        }
    }
    text
}
