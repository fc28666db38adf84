//! `timegap bench --graph FILE`: a graph of the user's as real processes, measured as the car's chain is.
//!
//! ```text
//! FILE ─ file ─► plan ─┬─► node: a process of each node ─ trail: stamps in each message ─► times: chains, counts ─┐
//!                      └─► group: start, faults, succession, end ────────────────────────► results ─► document ◄──┘
//! ```
//!
//! Nodes use what the car's services use: iceoryx2's ports and futexes, the end-to-end protection, epochs, the
//! succession of processes, histograms in shared memory, and the accounting of a chain ([`runtime::chain`]). A process
//! that only sleeps runs beside them, as the machine's floor. [`mod@file`] shows the keys.

mod document;
pub mod file;
mod group;
mod load;
mod node;
mod page;
mod plan;
mod ports;
mod results;
mod times;
mod trail;

pub use node::run as run_node;

use bench::BenchArguments;
use bench::plan::progress_bar;
use bench::stage::Stage;
use group::Launcher;
use plan::Graph;
use report::output::OutputDirectory;
use report::results::Schema;
use results::Report;
use runtime::scheduling::usable_cores;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use supervise::{Error, MachineError, UsageError, check_room};

/// Name of the graph's file in a run's root.
const FILE: &str = "graph.json";
/// Longest file of a graph, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Shared memory of a process beside its messages, bytes.
const PROCESS_BYTES: usize = 1 << 20;
/// Messages in a receiver's buffer, and those that it may hold.
const BUFFER: usize = 6;
/// Period of the floor's process, where no node of the first chain has a timer, µs.
const FLOOR_US: u32 = 1_000;

impl Graph {
    /// Reads the file of a graph.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let error = Error::path("read", path);
        let metadata = std::fs::metadata(path).map_err(error)?;
        if !metadata.is_file() || metadata.len() > MAX_BYTES {
            let expected = format_args!("a file of at most {MAX_BYTES} bytes");
            return Err(UsageError::at(path.display(), "no graph", expected).into());
        }
        let text = std::fs::read_to_string(path).map_err(error)?;
        Ok(Self::parse(&path.display().to_string(), &text)?)
    }

    /// Reads what the launcher wrote below the root of a run.
    fn read(root: &Path) -> Result<Self, Error> {
        let path = root.join(FILE);
        let text = std::fs::read_to_string(&path).map_err(Error::path("read", &path))?;
        let mistake = |why| UsageError::at(path.display(), why, "a graph of this program");
        Ok(serde_json::from_str(&text).map_err(mistake)?)
    }

    fn write(&self, root: &Path) -> Result<(), Error> {
        let path = root.join(FILE);
        let text = serde_json::to_string(self).expect("plain data");
        std::fs::write(&path, text).map_err(Error::path("write", &path))
    }

    /// Refuses what this machine does not have: cores, shared memory.
    fn check_machine(&self, file: &Path) -> Result<(), MachineError> {
        let cores = usable_cores();
        for node in &self.nodes {
            if let Some(core) = node.core.filter(|core| !cores.contains(core)) {
                let known: Vec<_> = cores.iter().map(ToString::to_string).collect();
                return Err(MachineError(format!(
                    "{}: node {} is to run on core {core}, and this process may use core {}",
                    file.display(),
                    node.name,
                    known.join(", ")
                )));
            }
        }
        let processes: usize = self.nodes.iter().map(|node| 1 + usize::from(node.standby)).sum();
        let bytes = |topic: &plan::Topic| {
            let peers = ports::peers(topic);
            // A sender's segment; one that died may still have its own.
            2 * trail::length(topic) * (peers.receivers * BUFFER + 3)
        };
        let topics: usize = self.topics.iter().map(bytes).sum();
        check_room((topics + processes * PROCESS_BYTES) as u64)
    }

    /// Core and period of the floor's process: those of the first chain's last node and source.
    fn floor(&self) -> (usize, u32) {
        let path = self.chains.first().map(|chain| chain.path.as_slice()).unwrap_or_default();
        let last = path.last().map_or(0, |hop| hop.node);
        let core = node::request(self, last).core.unwrap_or_default();
        let period_ns =
            path.first().and_then(|hop| self.nodes[hop.node].callbacks[hop.callback].period_ns);
        (core, period_ns.map_or(FLOOR_US, |ns| (ns / 1_000) as u32))
    }
}

/// Runs the command.
///
/// # Errors
/// A file that is no graph, or a machine on which it cannot run.
pub fn run(file: &Path, arguments: &BenchArguments) -> Result<ExitCode, Error> {
    let mut graph = Graph::open(file)?;
    if let Some(seconds) = arguments.seconds {
        graph.duration_s = seconds;
    }
    graph.check_machine(file)?;
    let output = OutputDirectory::create(&arguments.results.output, "graph")?;
    let interrupted = Arc::new(AtomicBool::new(false));
    supervise::flag_end(&interrupted)?;
    let stage = Stage::create(Arc::clone(&interrupted))?;
    let length = Duration::from_secs_f64(graph.duration_s);
    let bar = progress_bar(length, arguments.results.json);
    let (core, period_us) = graph.floor();
    let mut launcher = Launcher::start(&graph, &stage)?;
    stage.watch(launcher.leader());
    let metronome = stage.metronome_on(core, graph.scheduling, period_us)?;
    launcher.begin(&interrupted)?;
    let length_ns = length.as_nanos();
    let ran = launcher.run(&interrupted, |now_ns| {
        let is_running = now_ns > 0 && u128::from(now_ns.unsigned_abs()) < length_ns;
        metronome.count(is_running);
        bar.set_position(now_ns.max(0).unsigned_abs() / 1_000_000);
    });
    bar.finish_and_clear();
    let (group, outcome) = launcher.end();
    let floor = metronome.finish()?;
    ran?;
    let (report, histograms) = Report::of(&graph, &group, outcome, (core, period_us, &floor))?;
    let document = document::of(&report, &histograms);
    arguments.results.deliver(&document, &output)?;
    Ok(document.exit_code())
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Report>("graph")
}
