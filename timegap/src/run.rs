//! `timegap run`: one scenario, from the file to the results.

use crate::live::{Live, LiveOptions};
use clap::Args;
use controller::law::Formulation;
use perception_sim::Alone;
use report::output::{HISTOGRAMS, OutputDirectory, histogram_log};
use report::results::ResultOptions;
use report::summary::{self, Summary};
use report::{RunPicture, print, trajectory};
use runtime::{Mode, RuntimeError, Sealing, die_with_this_thread};
use scenario::Scenario;
use scenario::quantity::{Seed, StationId};
use std::os::unix::process::ExitStatusExt;
use std::process::ExitCode;
use std::time::Instant;
use sumo::Seat;
use supervise::report::Outcome;
use supervise::{
    Ended, Error, GroupOptions, Keep, Moment, ScenarioOptions, UsageError, check_targets, drive,
    open,
};

/// Simulated time between two positions of the progress bar, ms: a call costs as much as a message.
const SHOWN_EACH_MS: u64 = 100;

#[derive(Debug, Args)]
pub struct RunArguments {
    /// Name of a built-in scenario (see `timegap list`), a TOML file, an OpenSCENARIO file (.xosc),
    /// or a configuration of SUMO (.sumocfg) with --ego
    #[arg(default_value = "cacc-a")]
    pub scenario: String,
    /// Set a parameter of an OpenSCENARIO file (repeatable)
    #[arg(long = "param", value_name = "NAME=VALUE")]
    pub parameters: Vec<String>,
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    /// Exchange radio frames with roadside units on other hosts: udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5;
    /// or play a capture: pcap:FILE
    #[arg(long, value_name = "ADDRESS")]
    pub radio: Option<String>,
    #[command(flatten)]
    pub group: GroupOptions,
    /// Clock: `realtime`, or `lockstep` with simulated time and repeatable bytes
    #[arg(long, value_parser = supervise::mode(), default_value = "realtime")]
    pub mode: Mode,
    /// Drive this number of egos on the way of --ego in one SUMO, one behind the other: a run of its own each
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16),
        conflicts_with_all = ["watch", "junit", "markdown", "bridge"])]
    pub egos: Option<u32>,
    /// Run all services in one process: lockstep only, same bytes, no recording
    #[arg(long, conflicts_with_all = ["programs", "processes", "bridge"])]
    pub in_process: bool,
    /// Compute the digests of all messages also with --in-process; a group of processes always does in lockstep
    #[arg(long, requires = "in_process")]
    pub digests: bool,
    #[command(flatten)]
    pub results: ResultOptions,
    #[command(flatten)]
    pub live: LiveOptions,
    /// Refuse a scenario that has notes: each is an error
    #[arg(long)]
    pub strict: bool,
    /// Do not record the topics
    #[arg(long)]
    pub no_record: bool,
    /// Show the run live to viewers on this machine: foxglove or foxglove:PORT
    #[arg(long, value_name = "VIEWER")]
    pub bridge: Option<String>,
}

pub fn run(mut arguments: RunArguments) -> Result<ExitCode, Error> {
    let begun = Instant::now();
    let options = ScenarioOptions {
        parameters: arguments.parameters.clone(),
        radio: arguments.radio.clone(),
        is_for_one_law: true,
        is_in_lockstep: arguments.in_process || arguments.mode == Mode::Lockstep,
        ..arguments.scenario_options.clone()
    };
    let mut scenario = open(&arguments.scenario, &options)?;
    for notice in scenario.notices() {
        eprintln!("{}: {notice}", if arguments.strict { "error" } else { "note" });
    }
    if arguments.strict && scenario.notices().next().is_some() {
        return Ok(ExitCode::from(2));
    }
    if let Some(why) = scenario.hindrance() {
        eprintln!("error: {why}: the story of {} cannot happen", arguments.scenario);
        return Ok(ExitCode::FAILURE);
    }
    check_targets(&scenario)?;
    let mode = arguments.mode;
    if arguments.in_process && mode == Mode::Realtime {
        let why = "in realtime every service is a process";
        return Err(UsageError::at("--in-process", why, "to add --mode lockstep").into());
    }
    if let Some(egos) = arguments.egos {
        let Some(seat) = Seat::given() else { return run_egos(&scenario, egos) };
        let out = arguments.results.output.out.as_mut();
        out.into_iter().for_each(|out| out.push(format!("ego-{}", seat.number)));
        // The egos before it leave room first.
        let before = seat.number - 1;
        arguments.group.ready_timeout += sumo::ROOM_S * f64::from(before);
        scenario.seed = Seed::of((scenario.seed.value() + u64::from(before)) % i64::MAX as u64);
        if scenario.has_obu() {
            let first = scenario.v2x.obu.station_id.value();
            scenario.v2x.obu.station_id = StationId::of(first.saturating_add(before));
        }
    }
    let bridge = arguments.bridge.as_deref().map(crate::bridge::address).transpose()?;
    supervise::hold_signals()?;
    let output = OutputDirectory::create(&arguments.results.output, scenario.name.as_str())?;
    output.write_input("scenario.toml", scenario.to_toml().as_bytes())?;

    let mut live = Live::open(&arguments.live, &scenario, scenario.controller.name.as_str())?;
    let length_s = scenario.duration_s.value();
    let quiet = arguments.results.json || arguments.live.watch || length_s <= 1.0;
    let bar = print::bar((length_s * 1e3) as u64, "{msg} {wide_bar} {percent:>3} %", quiet);
    bar.set_message(scenario.name.as_str().to_owned());
    let (mut drove, mut shown_ms) = (false, 0);
    let mut watch = |moment: &Moment<'_>| {
        drove = true;
        let at_ms = moment.time_ns.unsigned_abs() / 1_000_000;
        if at_ms >= shown_ms + SHOWN_EACH_MS {
            shown_ms = at_ms;
            bar.set_position(at_ms);
        }
        live.look(moment);
    };
    let result = if arguments.in_process {
        // Until a signal, which is blocked since before the run.
        let sealing = if arguments.digests { Sealing::Sealed } else { Sealing::Unsealed };
        supervise::in_process::run_watched(&scenario, sealing, &supervise::is_signalled, &mut watch)
    } else {
        let keep = Keep {
            live_file: Some(output.path().join("live.json")),
            recording: (!arguments.no_record).then(|| output.path().join(recorder::FILE)),
            bridge,
        };
        drive(&scenario, mode, &arguments.group, Some(keep), &mut watch)
    };
    bar.finish_and_clear();
    if result.is_ok() || drove {
        // The recording is kept in any case.
        output.keep();
    }
    live.end();
    let group = result?;
    let summary = Summary::new(&scenario, mode, &group, begun.elapsed());
    let figures = group.formulation(&scenario).map_or_else(Vec::new, Formulation::figure_names);
    let picture = RunPicture::of(&scenario, &group).judged(&summary.requirements);
    let document = report::run_document(&scenario, &summary, &picture)
        .file("trajectory.csv", trajectory::csv(&group.drive, &figures));
    let document = match mode {
        Mode::Realtime => document.file(HISTOGRAMS, histogram_log(&summary::histograms(&group))),
        // Simulated time has no latencies.
        Mode::Lockstep => document,
    };
    for (service, line) in &group.wrote {
        print::note(&format!("{service}: {line}"));
    }
    let is_by_sumo = group.wrote.iter().any(|(_, line)| line.contains("SUMO: "));
    let delivered = arguments.results.deliver(&document, &output);
    // A closed terminal interrupts the run and accepts no more text.
    if group.ended != Ended::Interrupted {
        delivered?;
    }
    Ok(match (&group.ended, summary.outcome) {
        (Ended::Interrupted, _) => ExitCode::from(130),
        // The program beside the run is a part of the machine.
        (Ended::Broken { .. }, _) if is_by_sumo => ExitCode::from(3),
        (_, Outcome::Completed) => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// Drives the egos, each by this command with a seat. The verdict is the worst of theirs.
fn run_egos(scenario: &Scenario, egos: u32) -> Result<ExitCode, Error> {
    let Some(config) = &scenario.traffic.sumo else {
        let why = "SUMO does not have the traffic";
        return Err(UsageError::option("--egos", egos, why, "a scenario with traffic.sumo").into());
    };
    let (program, deadline_s) = ((&**config, scenario.seed.value()), scenario.traffic.deadline_s);
    let (deadline_s, alone) = (deadline_s.value(), &mut Alone::default());
    let done = sumo::drive_egos(program, deadline_s, alone, egos, die_with_this_thread);
    let done = done.map_err(|error| RuntimeError::Program(Box::new(error)))?;
    let mut worst = 0;
    for (output, number) in done.iter().zip(1..) {
        print::out(&String::from_utf8_lossy(&output.stdout))?;
        if let Some(signal) = output.status.signal() {
            let ended = format!("signal {signal} ended the run of ego {number}");
            print::note(&format!("note: {ended}; the others went on"));
        }
        worst = worst.max(output.status.code().unwrap_or(1));
    }
    Ok(ExitCode::from(worst as u8))
}
