//! `timegap recording trace`: a recorded run for Perfetto (<https://ui.perfetto.dev>).
//!
//! Each service has a track with a slice per cycle. Arrows follow the chains from radar over controller to plant.
//! Missed deadlines and faults are instants, and the drive's figures have tracks of their own.
//!
//! Times are the messages' own stamps. A slice extends from the scheduled release of its cycle to the cycle's last
//! publication. It is response time with waits, not processor time, which messages do not carry. An arrow begins at the
//! publication of the radar's message.

mod encode;
mod proto;
mod timeline;

use crate::recordings::{expect_another_file, print_damage};
use clap::Args;
use encode::{Frame, begin, events};
use messages::Service;
use recorder::{Damage, Record, Recording};
use report::print;
use report::results::Document;
use scenario::Scenario;
use serde::Serialize;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::Error;
use timeline::{Cycle, Incident, Timeline};

#[derive(Debug, Args)]
pub struct TraceArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// File for the trace [default: trace.pftrace beside the recording]
    #[arg(long, value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Print the counts as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct Written {
    schema_version: u32,
    file: String,
    bytes: usize,
    cycles: usize,
    chains: usize,
    deadline_misses: usize,
    incidents: usize,
}

pub fn run(arguments: &TraceArguments) -> Result<ExitCode, Error> {
    let recording = Recording::open(&arguments.run)?;
    let text = &recording.metadata().scenario;
    let scenario = Scenario::parse("the recording's scenario", text)?;
    let file = match &arguments.file {
        Some(file) => file.clone(),
        None => recording.path().with_file_name("trace.pftrace"),
    };
    expect_another_file(&recording, &file)?;
    let written = write(&recording, &scenario, &file);
    let (written, damage) = written.map_err(Error::path("write", &file))?;
    let damage = [recording.damage(), &damage].concat();
    print_damage(&recording, &damage);
    let Written { cycles, chains, deadline_misses, incidents, .. } = written;
    let events = format!(
        "{cycles} cycles, {chains} chains, {deadline_misses} deadlines missed, {incidents} incidents"
    );
    let verdict = "open it at https://ui.perfetto.dev (it stays on this machine)";
    let facts = [("results", written.file.clone()), ("events", events)];
    let document = Document::new("trace", "Trace", &written).facts("Trace", facts);
    print::show(arguments.json, &document.verdict(true, verdict))?;
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Length of the parts in which a recording is read, ns of run time.
const PART_NS: i64 = 1_000_000_000;
/// Overlap of a part with its neighbours, longer than a chain, ns.
const MARGIN_NS: i64 = 500_000_000;

/// Writes the trace part by part, so that memory does not grow with the recording.
fn write(
    recording: &Recording,
    scenario: &Scenario,
    path: &Path,
) -> io::Result<(Written, Vec<Damage>)> {
    let frame = frame(recording, scenario);
    let mut file = BufWriter::new(File::create(path)?);
    let start = begin(&frame);
    file.write_all(&start)?;
    let mut written = Written {
        schema_version: 1,
        file: path.to_string_lossy().into_owned(),
        bytes: start.len(),
        cycles: 0,
        chains: 0,
        deadline_misses: 0,
        incidents: 0,
    };
    let mut faults = faults(recording.path());
    let mut records = recording.records();
    let mut held: VecDeque<Record> = VecDeque::new();
    let mut next = records.next();
    let mut carried = Vec::new();
    let mut from_ns = i64::MIN;
    while let Some(first) = held
        .iter()
        .map(|r| r.log_time_ns)
        .find(|ns| *ns >= from_ns)
        .or(next.as_ref().map(|record| record.log_time_ns))
    {
        // A part begins at a message, the first part at the first message.
        let begin_ns = first.div_euclid(PART_NS).saturating_mul(PART_NS).max(from_ns);
        let end_ns = begin_ns.saturating_add(PART_NS);
        let reach_ns = end_ns.saturating_add(MARGIN_NS);
        while let Some(record) = next.take_if(|r| r.log_time_ns < reach_ns || reach_ns == i64::MAX)
        {
            held.push_back(record);
            next = records.next();
        }
        let mut timeline = Timeline::of(held.make_contiguous(), &carried, scenario);
        timeline.incidents.append(&mut faults.clone());
        let is_last = next.is_none()
            && (end_ns == i64::MAX || held.back().is_none_or(|last| last.log_time_ns < end_ns));
        let within = from_ns..if is_last { i64::MAX } else { end_ns };
        let bytes = events(&timeline, &frame, &within);
        file.write_all(&bytes)?;
        written.bytes += bytes.len();
        written.count(&timeline, &frame, &within);
        if is_last {
            break;
        }
        faults.retain(|fault| !within.contains(&fault.at_ns));
        let keep_ns = end_ns.saturating_sub(MARGIN_NS);
        carried = timeline.last_before(keep_ns);
        while held.front().is_some_and(|record| record.log_time_ns < keep_ns) {
            held.pop_front();
        }
        from_ns = within.end;
    }
    file.flush()?;
    Ok((written, records.damage().to_vec()))
}

impl Written {
    /// Counts events of `timeline` that begin in `within`.
    fn count(&mut self, timeline: &Timeline, frame: &Frame, within: &Range<i64>) {
        let is_here = |cycle: &Cycle| within.contains(&cycle.release_ns);
        let cycles = timeline.cycles.iter().filter(|cycle| is_here(cycle));
        self.deadline_misses +=
            cycles.clone().filter(|cycle| cycle.missed(frame.deadline_ns)).count();
        self.cycles += cycles.count();
        let chains = timeline.chains.iter();
        self.chains += chains.filter(|chain| is_here(&timeline.cycles[chain.control])).count();
        let incidents = timeline.incidents.iter();
        self.incidents += incidents.filter(|incident| within.contains(&incident.at_ns)).count();
    }
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

/// Faults in the summary beside the recording; empty without a summary.
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

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Message, Odometry};
    use recorder::{LawNames, Metadata, Tally, Writer};
    use runtime::Mode;
    use scenario::Overrides;

    #[test]
    fn times_at_the_end_of_their_range_end_too() {
        let scenario = Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default()))
            .expect("built in");
        let metadata = Metadata::new(&scenario, Mode::Lockstep, 0, [].into(), LawNames::default());
        let corner = std::env::temp_dir().join(format!("timegap-trace-{}", std::process::id()));
        std::fs::create_dir_all(&corner).expect("a directory");
        let path = corner.join("recording.mcap");
        let mut writer =
            Writer::begin(File::create(&path).expect("a file"), &metadata).expect("begun");
        for at_ns in [0, i64::MAX - PART_NS, i64::MAX - 1, i64::MAX, i64::MAX] {
            let odometry: Odometry = bytemuck::Zeroable::zeroed();
            let bytes = bytemuck::bytes_of(&odometry);
            writer.message(Odometry::TOPIC, at_ns, bytes).expect("written");
        }
        writer.finish(&Tally::default()).expect("ended");
        let recording = Recording::open(&path).expect("a recording");
        let written = write(&recording, &scenario, &corner.join("trace.pftrace"));
        std::fs::remove_dir_all(&corner).expect("ours");
        assert!(written.expect("written").0.bytes > 0);
    }
}
