//! `timegap trace`: a recorded run for Perfetto (<https://ui.perfetto.dev>).
//!
//! One track per service with a slice per cycle, arrows along the chains from radar over controller
//! to plant, missed deadlines and faults as instants, and the drive's figures. Times are the
//! messages' own stamps: a slice reaches from the scheduled release of its cycle to the cycle's last
//! publication. That is response time, waits included, and not use of a processor: messages do not
//! carry what a processor did, so there is no track for one. An arrow leaves where the radar's message
//! was published.

mod encode;
mod proto;
mod timeline;

use clap::Args;
use encode::{Frame, encode};
use group::Error;
use messages::Service;
use recorder::Recording;
use report::print;
use scenario::Scenario;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use timeline::{Incident, Timeline};

/// Arguments of `trace`.
#[derive(Debug, Args)]
pub struct TraceArguments {
    /// A run's directory of results, or a recording
    pub run: PathBuf,
    /// Where to write the trace [default: trace.pftrace beside the recording]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print what was written as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// What was written.
#[derive(Debug, Serialize)]
struct Written {
    schema_version: u32,
    file: PathBuf,
    bytes: usize,
    cycles: usize,
    chains: usize,
    deadline_misses: usize,
    incidents: usize,
}

/// Runs the command.
pub fn run(arguments: &TraceArguments) -> Result<ExitCode, Error> {
    let recording =
        Recording::open(&arguments.run).map_err(|error| Error::Usage(error.to_string()))?;
    let metadata = recording.metadata();
    let scenario = Scenario::parse("the recording's scenario", &metadata.scenario)
        .map_err(|error| Error::Usage(error.to_string()))?;
    let mut timeline = Timeline::of(&recording, &scenario);
    timeline.incidents.extend(faults(recording.path()));
    let frame = frame(&recording, &scenario);
    let bytes = encode(&timeline, &frame);
    let file = match &arguments.out {
        Some(file) => file.clone(),
        None => recording.path().with_file_name("trace.pftrace"),
    };
    std::fs::write(&file, &bytes).map_err(|reason| Error::Path {
        action: "write",
        path: file.clone(),
        reason,
    })?;
    let misses = timeline.cycles.iter().filter(|cycle| cycle.missed(frame.deadline_ns)).count();
    let written = Written {
        schema_version: 1,
        bytes: bytes.len(),
        cycles: timeline.cycles.len(),
        chains: timeline.chains.len(),
        deadline_misses: misses,
        incidents: timeline.incidents.len(),
        file,
    };
    for damage in recording.damage() {
        eprintln!("{}: {damage}", recording.path().display());
    }
    if arguments.json {
        let json = serde_json::to_string_pretty(&written).expect("plain data");
        print::out(&(json + "\n"))?;
    } else {
        print::out(&format!(
            "{}: {} cycles, {} chains, {} deadlines missed, {} incidents, {:.2} MiB\n\
             open it at https://ui.perfetto.dev (it stays on this machine)\n",
            written.file.display(),
            written.cycles,
            written.chains,
            written.deadline_misses,
            written.incidents,
            written.bytes as f64 / f64::from(1 << 20),
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn frame(recording: &Recording, scenario: &Scenario) -> Frame {
    let metadata = recording.metadata();
    let of = |service: Service| metadata.scheduling.get(service.name());
    let granted = Service::ALL.into_iter().filter_map(|service| {
        let granted = of(service)?;
        let core = granted.core.map_or_else(String::new, |core| format!(", core {core}"));
        Some((service, format!("({}{core})", granted.granted)))
    });
    Frame {
        title: format!(
            "{} · {} · {}",
            metadata.scenario_name,
            metadata.controller,
            metadata.mode.name()
        ),
        started_unix_ns: metadata.started_unix_ns,
        granted: granted.collect(),
        deadline_ns: i64::from(scenario.controller.deadline().value()) * 1_000_000,
    }
}

/// The faults that the summary beside the recording tells of; none where there is no summary.
fn faults(recording: &Path) -> Vec<Incident> {
    let summary = std::fs::read(recording.with_file_name("summary.json")).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap_or_default();
    let faults = summary["faults"].as_array().into_iter().flatten();
    faults
        .filter_map(|fault| {
            let kind = fault["kind"].as_str()?;
            let service = fault["service"].as_str().and_then(|name| name.parse().ok());
            Some(Incident {
                service,
                at_ns: (fault["t_s"].as_f64()? * 1e9).round() as i64,
                what: format!("fault: {kind}"),
            })
        })
        .collect()
}
