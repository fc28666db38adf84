//! `timegap recording replay`: feeds a recorded run's inputs to the controller again.
//!
//! The controller is the real process on real topics. A replayer takes the place of all other services and
//! sends the recorded samples. It releases the controller at the recorded instants. At each release the
//! controller gets the samples that its recorded diagnostics name, also in silent cycles. Each process of a
//! restarted controller is replayed separately.
//!
//! The recorded controller must give the same outputs. In lockstep every byte of every command and diagnostics
//! message is compared. In realtime these are left out: publication time and checksum, start of the cycle's
//! wait, context switches and page faults. A recording does not hold the arrival of plans made beside the
//! loop. In a replay every plan is in time, so that a realtime run with late plans may differ.

mod comparison;

use super::{expect_another_file, open, print_damage};
use clap::Args;
use comparison::{Comparison, Pairs};
use controller::laws;
use messages::Service;
use recorder::Recording;
use report::print;
use report::print::count_bar;
use report::results::Document;
use runtime::Program;
use scenario::{Overrides, Scenario, Setting};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, UsageError, replay, service_program};

#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// Use another control law (see `timegap list`) and compare its commands
    #[arg(long, value_name = "NAME")]
    pub controller: Option<String>,
    /// Use PROGRAM as the controller, like `run --service controller=PROGRAM`
    #[arg(long, value_name = "controller=PROGRAM", value_parser = service_program)]
    pub service: Option<(Service, PathBuf)>,
    /// Change a key of the recorded scenario, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Setting>,
    /// File for both controllers' requests [default: replay.csv beside the recording]
    #[arg(long, value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Print the comparison as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &ReplayArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let (scenario, changed) = scenario(&recording, arguments)?;
    let programs = programs(&recording, &scenario, arguments)?;
    let takes = recording.takes();
    let cycles: u64 = takes.iter().map(|take| take.cycles).sum();
    if cycles == 0 {
        print_damage(&recording, &recording.survey().damage);
        let place = recording.path().display();
        return Err(UsageError::at(place, "no control cycle", "one that can be replayed").into());
    }
    let path =
        arguments.file.clone().unwrap_or_else(|| recording.path().with_file_name("replay.csv"));
    expect_another_file(&recording, &path)?;
    let bar = count_bar(usize::try_from(cycles).unwrap_or(usize::MAX), arguments.json);
    let program = arguments.service.as_ref().map(|(_, program)| program);
    let mut table = Table::begin(path);
    let mut comparison = Comparison::new(&recording, &scenario, changed, programs);
    for take in &takes {
        let mut pairs = Pairs::new(recording.cycles(take), &mut comparison, &mut table);
        replay(&scenario, &recording, take, program, &mut |said| {
            bar.set_position(pairs.add(said));
        })?;
        pairs.finish(take);
    }
    bar.finish_and_clear();
    comparison.finish();
    let (path, written) = table.finish();
    print::show(arguments.json, &document(&comparison, &path))?;
    let damage = recording.survey().damage;
    print_damage(&recording, &damage);
    written?;
    let is_right = (changed || comparison.identical) && damage.is_empty();
    Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The recorded scenario, and whether it was changed.
fn scenario(recording: &Recording, arguments: &ReplayArguments) -> Result<(Scenario, bool), Error> {
    let mut overrides = Overrides::new();
    if let Some(controller) = &arguments.controller {
        overrides.option("--controller", "controller.name", controller.as_str());
    }
    arguments.set.iter().cloned().for_each(|setting| overrides.set(setting));
    let text = &recording.metadata().scenario;
    let recorded = Scenario::parse("the recorded scenario", text)?;
    let scenario = Scenario::parse_with("the recorded scenario", text, &overrides, &laws::check)?;
    let changed = scenario != recorded;
    Ok((scenario, changed))
}

/// The user's program that drove in the recording, and the one that drives now.
#[derive(Debug, Default)]
pub(super) struct Programs {
    recorded: Option<Program>,
    replayed: Option<Program>,
}

fn programs(
    recording: &Recording,
    scenario: &Scenario,
    arguments: &ReplayArguments,
) -> Result<Programs, Error> {
    let recorded = recording.metadata().programs.get(Service::Controller.name()).cloned();
    let hosted = laws::program(scenario)?;
    let replayed = match &arguments.service {
        Some((Service::Controller, path)) => {
            let here = std::env::current_dir().unwrap_or_default();
            Some(supervise::of_service(Service::Controller, path, &here)?)
        }
        Some((other, _)) => {
            let why = "a replay has the controller alone";
            return Err(UsageError::option("--service", other, why, "controller=PROGRAM").into());
        }
        None => hosted,
    };
    if let (Some(program), None, None) = (&recorded, &replayed, &arguments.controller) {
        let (command, sha256) = (program.command.escape_debug(), program.sha256.escape_debug());
        let why = format!("was driven by the program `{command}` (sha256 {sha256})");
        let expected =
            "--service controller=PROGRAM, or --controller NAME to compare it with another law";
        return Err(UsageError::at(recording.path().display(), why, expected).into());
    }
    if let (Some(then), Some(now)) = (&recorded, &replayed)
        && then.sha256 != now.sha256
    {
        let (file, now, then) = (now.file.display(), now.short_digest(), then.short_digest());
        print::note(&format!(
            "note: {file} has sha256 {now}..., the recorded program had {then}..."
        ));
    }
    Ok(Programs { recorded, replayed })
}

/// Both controllers' requests, a row per cycle.
struct Table {
    path: PathBuf,
    file: Result<BufWriter<File>, std::io::Error>,
}

impl Table {
    fn begin(path: PathBuf) -> Self {
        let begin = || {
            let mut file = BufWriter::new(File::create(&path)?);
            file.write_all(
                b"incarnation,step,time_s,recorded_request_mps2,replayed_request_mps2,difference_mps2\n",
            )?;
            Ok(file)
        };
        let file = begin();
        Self { path, file }
    }

    /// Adds a row. An error is kept for the end: the comparison is printed first.
    fn add(&mut self, row: &str) {
        let Ok(file) = &mut self.file else { return };
        if let Err(error) = writeln!(file, "{row}") {
            self.file = Err(error);
        }
    }

    fn finish(self) -> (PathBuf, Result<(), Error>) {
        let written = self.file.and_then(|mut file| file.flush());
        let written = written.map_err(Error::path("write", &self.path));
        (self.path, written)
    }
}

fn document(c: &Comparison, table: &Path) -> Document {
    let laws = if c.recorded_controller == c.replayed_controller {
        c.recorded_controller.clone()
    } else {
        format!("{} recorded, {} replayed", c.recorded_controller, c.replayed_controller)
    };
    let mut facts = vec![("replayed".to_owned(), print::counted(c.cycles, "control cycle"))];
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
    for why in &c.cut_short {
        add("CUT SHORT", why.clone());
    }
    if !c.changed {
        let same = |identical: u64, all: u64| match identical == all {
            true => format!("all {all} byte-identical"),
            false => format!("ONLY {identical} of {all} BYTE-IDENTICAL"),
        };
        add("commands", same(c.identical_commands, c.commands));
        add("diagnostics", same(c.identical_diagnostics, c.cycles));
        if !c.not_compared.is_empty() {
            add("", format!("not compared: {}", c.not_compared.join(", ")));
        }
    }
    if !c.identical {
        let (most, at_s) = (c.max_request_difference_mps2, c.max_request_difference_at_s);
        let rms = c.rms_request_difference_mps2;
        let requests = format!(
            "differ by at most {most:.3} m/s², at {at_s:.2} s; root mean square {rms:.3} m/s²"
        );
        add("requests", requests);
        if let Some(first) = &c.first_difference {
            add("first", first.to_string());
        }
    }
    add("results", table.display().to_string());
    Document::new("replay", "Replay", c)
        .about(format!("{} · {laws} · {}", c.scenario, c.mode))
        .facts("Replay", facts)
}
