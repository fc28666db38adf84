//! `timegap bench --graph FILE`: a graph of the user's as real processes, measured as the car's chain is.
//!
//! ```text
//! FILE ─► plan ─┬─► node: a process of each node ─ ports: stamps in each message ─► chains: reactions ─┐
//!               └─► group: start, faults, succession, end ─────────────────────────────► results ◄─────┘
//! ```
//!
//! Nodes use what the car's services use: iceoryx2's ports and futexes, the end-to-end protection, epochs, the
//! succession of processes, histograms in shared memory, and the accounting of a chain ([`runtime::chain`]). A process
//! that only sleeps runs beside them, as the machine's floor.

mod chains;
mod group;
mod load;
mod node;
mod plan;
mod ports;
mod results;

pub use node::run as run_node;

use bench::BenchArguments;
use bench::peer::Outcome;
use bench::plan::progress_bar;
use bench::stage::Stage;
use group::Launcher;
use plan::Graph;
use report::gate::Baseline;
use report::output::OutputDirectory;
use report::results::Schema;
use runtime::scheduling::usable_cores;
use scenario::quantity::Duration as Seconds;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use supervise::{Error, MachineError, check_room};

/// Time that a process gets to leave.
const GRACE: Duration = Duration::from_secs(2);
/// Shared memory of a process beside its messages, bytes.
const PROCESS_BYTES: usize = 1 << 20;
/// Messages in a receiver's buffer, and those that it may hold.
const BUFFER: usize = 6;
/// Period of the floor's process where the first chain has no timer, ns.
const FLOOR_NS: i64 = 1_000_000;

impl Graph {
    /// Refuses what this machine does not have: cores, shared memory.
    fn check_machine(&self, file: &Path) -> Result<(), MachineError> {
        let cores = usable_cores();
        for node in &self.nodes {
            let core = node.core.map(|core| usize::from(core.value()));
            if let Some(core) = core.filter(|core| !cores.contains(core)) {
                let (file, name) = (file.display(), node.name.as_str());
                let why = format!("is to run on core {core}, and this process may use {cores:?}");
                return Err(MachineError(format!("{file}: node {name} {why}")));
            }
        }
        // A sender's segment; one that died may still have its own.
        let bytes = |topic: &String| {
            let messages = ports::peers(self, topic).receivers * BUFFER + 3;
            2 * chains::Layout::of(self, topic).length * messages
        };
        let topics: usize = self.topics.keys().map(bytes).sum();
        check_room((topics + 2 * self.nodes.len() * PROCESS_BYTES) as u64)
    }

    /// Core and period of the floor's process, µs: those of the first chain's last node and source.
    fn floor(&self) -> (usize, u32) {
        let path = self.chains.first().map(|chain| chain.path.as_slice()).unwrap_or_default();
        let node =
            |name: Option<&String>| &self.nodes[name.and_then(|n| self.node(n)).unwrap_or(0)];
        let core = node::request(self, node(path.last())).core.unwrap_or_default();
        (core, (node(path.first()).period_ns().unwrap_or(FLOOR_NS) / 1_000) as u32)
    }
}

/// Runs the command.
///
/// # Errors
/// A file that is no graph, or a machine on which it cannot run.
pub fn run(file: &Path, arguments: &BenchArguments) -> Result<ExitCode, Error> {
    let text = Error::text_of(file, "graph")?;
    let mut graph = Graph::parse(&file.display().to_string(), &text)?;
    graph.duration_s = arguments.seconds.map_or(graph.duration_s, Seconds::of);
    graph.check_machine(file)?;
    let read = |file: &PathBuf| Baseline::read(file, "the graph.json of an earlier run");
    let baseline = arguments.against.as_ref().map(read).transpose()?;
    let output = OutputDirectory::create(&arguments.results.output, "graph")?;
    let interrupted = Arc::new(AtomicBool::new(false));
    supervise::flag_end(&interrupted)?;
    let stage = Stage::create(interrupted)?;
    let mut launcher = Launcher::new(&graph, &stage)?;
    let measured = measure(&mut launcher, &stage, arguments.results.json);
    launcher.roster.end_all(GRACE);
    let document = measured.and_then(|floor| {
        results::document(&graph, &launcher, &floor, (baseline.as_ref(), arguments.factor))
    });
    launcher.roster.dissolve().dismiss();
    let document = document?;
    arguments.results.deliver(&document, &output)?;
    Ok(document.exit_code())
}

/// Runs the nodes for the graph's length, with a process that only sleeps beside them: the floor.
fn measure(launcher: &mut Launcher<'_>, stage: &Stage, is_quiet: bool) -> Result<Outcome, Error> {
    launcher.start()?;
    let graph = launcher.graph;
    let (core, period_us) = graph.floor();
    let metronome = stage.metronome_on(core, graph.scheduling, period_us)?;
    let length_ns = graph.length_ns();
    let bar = progress_bar(Duration::from_nanos(length_ns.unsigned_abs()), is_quiet);
    let ran = launcher.run(|now_ns| {
        metronome.count((1..length_ns).contains(&now_ns));
        bar.set_position(now_ns.max(0).unsigned_abs() / 1_000_000);
    });
    bar.finish_and_clear();
    ran.and_then(|()| metronome.finish())
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<results::Report>("graph")
}
