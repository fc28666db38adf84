//! `timegap bench`: the overhead of timegap beside the machine's own floor.
//!
//! ```text
//! source ─ futex, message, payload ─► sink       wake-ups: machine's floor, transport
//! radar ─► controller ─► plant                  chain: reaction time, deadlines
//! metronome, same seconds and core              floor of the chain
//! ```
//!
//! First it answers which loops hold on this machine, as `timegap doctor` does ([`doctor::wake_ups`]). Then it
//! measures, for each scheduling, placement and load:
//!
//! 1. the machine's floor: lateness of absolute sleeps as in cyclictest, and the time for one process to wake another.
//!    The means are futex, eventfd and iceoryx2's event service;
//! 2. the transport: publish, wake and read through the services' own ports. Payloads have 64 B to 4 MiB, loaned and
//!    borrowed, bare or protected;
//! 3. the chain of the four services, with its reaction time and hops;
//! 4. deadline misses of the controller with the 100-step problem in its loop at periods from 100 ms to 1 ms.
//!    Beside them stand those of a process that sleeps and computes for the law's time on the same core;
//! 5. comparisons in alternating blocks of ours and its floor, which decide the goals.
//!
//! Goals are ratios to the floor with 95 % intervals, since absolute times depend on the machine. A goal is
//! met or missed only by its whole interval. A futex compared with itself shows in each run that the method
//! finds no difference without one.

mod baseline;
mod blocks;
mod chain;
pub mod document;
mod goals;
mod paired;
pub mod payload;
pub mod peer;
pub mod plan;
mod results;
pub mod setup;
pub mod stage;
mod statistics;
mod wake;

pub use peer::run as run_peer;

use self::peer::Outcome;
use self::plan::{Cell, Measure, millis, progress_bar};
use self::results::{
    ChainRow, DeadlineRow, Floor, FloorMeasure, FloorRow, Passing, Report, TransportRow,
};
use self::setup::Mechanism;
use self::stage::Stage;
use self::statistics::Events;
use clap::Args;
use messages::Topic;
use report::gate::Baseline;
use report::output::OutputDirectory;
use report::results::{ResultOptions, Schema};
use report::summary::Host;
use runtime::statistics::{Latencies, Percentiles};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use supervise::{Error, number_within};

/// Length of each measurement, s.
const FULL_S: f64 = 2.0;
/// Length of each measurement of a quick run, s.
const QUICK_S: f64 = 0.4;
/// Tag of the histogram of wake-ups.
const WAKE_UPS: &str = "wake-ups";
/// Period of the named floor figures, µs.
const REFERENCE_PERIOD_US: u32 = 1_000;

#[derive(Debug, Args)]
pub struct BenchArguments {
    /// Measure an idle machine under the best available scheduling only, in at most a minute; judge no p99
    #[arg(long)]
    pub quick: bool,
    /// Length of each measurement, s [default: 2, quick: 0.4]
    #[arg(long, value_name = "S", value_parser = number_within(0.05..=3600.0, "a number of seconds"))]
    pub seconds: Option<f64>,
    /// Write the result to FILE for later comparisons
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Compare with a file of --save, or with a graph.json; status 1 if a figure got worse
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Least growth that counts as worse, of a ratio to the floor or of a graph's reaction time
    #[arg(long, value_name = "F", default_value_t = 1.5, value_parser = number_within(1.0..=100.0, "a number"))]
    pub factor: f64,
    /// Run a graph of nodes of your own in place of the benchmark, and measure its chains (docs/graph.md)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["quick", "save"])]
    pub graph: Option<PathBuf>,
    #[command(flatten)]
    pub results: ResultOptions,
}

pub fn run(arguments: &BenchArguments) -> Result<ExitCode, Error> {
    let read = |file: &PathBuf| Baseline::read(file, "a file of `timegap bench --save`");
    let before = arguments.against.as_ref().map(read).transpose()?;
    let output = OutputDirectory::create(&arguments.results.output, "bench")?;
    let interrupted = Arc::new(AtomicBool::new(false));
    supervise::flag_end(&interrupted)?;
    let stage = Stage::create(Arc::clone(&interrupted))?;
    let (quick, cores, reference) = (arguments.quick, stage.cores().len(), stage.reference()?);
    let cells = plan::cells(quick, cores, reference);
    let compared = plan::comparisons(quick, cores, reference);
    let chains = plan::chain_blocks(quick, cores, reference);
    let seconds = arguments.seconds.unwrap_or(if quick { QUICK_S } else { FULL_S });
    let whole: Duration = (cells.iter().map(|cell| cell.estimate(seconds)))
        .chain(compared.iter().map(|(_, _, us)| plan::comparison_estimate(quick, *us)))
        .chain(chains.iter().map(plan::ChainBlocks::estimate))
        .sum();
    let bar = progress_bar(whole, arguments.results.json);
    bar.set_message("wake-ups");
    // Before any other work on this machine.
    let (wake_ups, latencies) = doctor::wake_ups::measure(&doctor::wake_ups::USUAL, seconds);
    let report = Report {
        schema_version: 1,
        host: Host::this(),
        quick,
        seconds,
        wake_ups: Some(wake_ups),
        refused: BTreeSet::new(),
        floor: Floor::default(),
        transport_us: Vec::new(),
        chain: Vec::new(),
        deadlines: Vec::new(),
        paired: Vec::new(),
        goals: Vec::new(),
        caveats: setup::caveats(cores, reference, setup::quota()),
        samples: Vec::new(),
        against: None,
    };
    let mut bench =
        Bench { stage: &stage, report, histograms: vec![(WAKE_UPS.to_owned(), latencies)] };
    let mut load = None;
    for cell in &cells {
        bar.set_message(cell.describe());
        // Neighbours in the plan share a load.
        if load.as_ref().is_none_or(|(kind, _)| *kind != cell.conditions.load) {
            drop(load.take());
            load = Some((cell.conditions.load, stage.load(cell.conditions.load)?));
        }
        let measured = bench.measure(cell);
        if interrupted.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        measured?;
        bar.inc(millis(cell.estimate(seconds)));
    }
    drop(load);
    bench.compare(&compared, &chains, &bar)?;
    bar.finish_and_clear();
    let Bench { mut report, histograms, .. } = bench;
    report.samples = baseline::samples(&report, arguments.factor);
    if let Some(path) = &arguments.save {
        let json = serde_json::to_string_pretty(&report).expect("plain data") + "\n";
        std::fs::write(path, json).map_err(Error::path("write", path))?;
    }
    report.against = before.map(|before| before.judge(&report.samples)).transpose()?;
    let document = document::of(&report, &histograms);
    let document = match &report.against {
        Some(against) => against.onto(document),
        None => document,
    };
    arguments.results.deliver(&document, &output)?;
    Ok(document.exit_code())
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Report>("bench")
}

struct Bench<'a> {
    stage: &'a Stage,
    report: Report,
    histograms: Vec<(String, Latencies)>,
}

impl Bench<'_> {
    fn measure(&mut self, cell: &Cell) -> Result<(), Error> {
        match cell.measure {
            Measure::Sleep => self.sleep(cell),
            Measure::Wake(mechanism) => self.wake(cell, mechanism),
            Measure::Chain => self.chain(cell),
        }
    }

    fn sleep(&mut self, cell: &Cell) -> Result<(), Error> {
        let metronome = self.stage.metronome(cell.conditions, cell.period_us)?;
        metronome.count(true);
        std::thread::sleep(Duration::from_secs_f64(self.report.seconds));
        let outcome = metronome.finish()?;
        let us = self.figure(cell, "sleep", &outcome);
        self.floor(cell, FloorMeasure::Sleep, us);
        Ok(())
    }

    fn wake(&mut self, cell: &Cell, mechanism: Mechanism) -> Result<(), Error> {
        let count = (self.report.seconds * 1e6 / f64::from(cell.period_us)).ceil() as u32;
        let outcome = self.stage.wake(mechanism, cell.conditions, cell.period_us, count)?;
        let us = self.figure(cell, &mechanism.name(), &outcome);
        match mechanism {
            Mechanism::Futex => self.floor(cell, FloorMeasure::Futex, us),
            Mechanism::Eventfd => self.floor(cell, FloorMeasure::Eventfd, us),
            Mechanism::Iceoryx2Event => self.floor(cell, FloorMeasure::Iceoryx2Event, us),
            Mechanism::Message | Mechanism::Detections => {
                let is_tracks = mechanism == Mechanism::Message;
                let topic = if is_tracks { Topic::RadarTracks } else { Topic::RadarDetections };
                self.transport(cell, topic.message_bytes(), Passing::Message, &outcome, us);
            }
            Mechanism::Payload { bytes, is_protected } => {
                let passing = if is_protected { Passing::Protected } else { Passing::Bare };
                self.transport(cell, bytes, passing, &outcome, us);
            }
        }
        Ok(())
    }

    fn transport(
        &mut self,
        cell: &Cell,
        bytes: usize,
        passing: Passing,
        outcome: &Outcome,
        us: Option<Percentiles>,
    ) {
        let Cell { conditions, period_us, .. } = *cell;
        let lost = us.map(|_| outcome.misses);
        let copied_bytes =
            (outcome.cycles > 0).then(|| outcome.copied_bytes as f64 / outcome.cycles as f64);
        let row = TransportRow { conditions, period_us, bytes, passing, copied_bytes, lost, us };
        self.report.transport_us.push(row);
    }

    fn floor(&mut self, cell: &Cell, measure: FloorMeasure, us: Option<Percentiles>) {
        let Cell { conditions, period_us, .. } = *cell;
        let row = FloorRow { measure, conditions, period_us, us };
        self.report.floor.add(row, REFERENCE_PERIOD_US);
    }

    /// The percentiles of an outcome, if the cell's conditions were granted.
    fn figure(&mut self, cell: &Cell, name: &str, outcome: &Outcome) -> Option<Percentiles> {
        let granted = &outcome.granted;
        self.report.refused.extend(granted.refused.iter().cloned());
        if granted.granted != granted.requested {
            return None;
        }
        let tag = format!("{name}:{}", cell.conditions.tag(cell.period_us));
        self.histograms.push((tag, outcome.latencies.clone()));
        outcome.latencies.percentiles_us()
    }

    fn chain(&mut self, cell: &Cell) -> Result<(), Error> {
        let chain = chain::run(self.stage, cell, self.report.seconds)?;
        let Cell { conditions, period_us, .. } = *cell;
        let floor = self.figure(cell, "sleep-beside-chain", &chain.floor);
        let sleep_jitter_us = floor.filter(|_| chain.as_asked);
        let beside = chain.floor_events();
        self.report.refused.extend(chain.refused);
        let tag = |name| format!("{name}:{}", conditions.tag(period_us));
        self.histograms.extend(chain.histograms.into_iter().map(|(name, h)| (tag(name), h)));
        let timing = chain.timing;
        let per_million = |of: Events| (of.cycles > 0).then(|| of.per_million());
        // Skipped releases are cycles that were due.
        let late = timing.deadline_misses.unwrap_or(0);
        let due = timing.cycles.map(|cycles| cycles.max(late));
        let ours = due.map(|cycles| Events { events: late, cycles });
        self.report.deadlines.push(DeadlineRow {
            conditions,
            period_us,
            cycles: due,
            misses: timing.deadline_misses,
            misses_per_million: ours.and_then(per_million),
            floor_cycles: beside.map(|floor| floor.cycles),
            floor_misses: beside.map(|floor| floor.events),
            floor_misses_per_million: beside.and_then(per_million),
        });
        // The plan has the futex before the chain.
        let futex = self.report.futex(conditions, period_us);
        let floor_sum_us =
            (|| Some(2.0 * sleep_jitter_us?.p50 + futex?.p50 + timing.solve_us?.p50))();
        self.report.chain.push(ChainRow {
            conditions,
            period_us,
            reaction_time_us: timing.reaction_time_us,
            designed_wait_us: timing.designed_wait_us,
            net_reaction_us: timing.net_reaction_us,
            floor_sum_us,
            hops_us: timing.hops_us,
            solve_us: timing.solve_us,
            sleep_jitter_us,
        });
        Ok(())
    }
}
