//! The process of a node: its ports, its releases, its cycles.
//!
//! ```text
//! ports open ─ ready ─ start ─┬─► take what came ─► released? ─► work ─► publish, wake readers ─┐
//!                             │                     no: sleep to the timer, or until woken      │
//!                             └─────────────────────────────────────────────────────────────────┘
//! ```
//!
//! A standby has its ports open and waits. It takes the node's epoch when the active process ends.

use crate::chains::Reactions;
use crate::load::{Program, spin_for};
use crate::plan::{Graph, Node};
use crate::ports::{Input, Output, Page};
use messages::{Header, Origins};
use runtime::scheduling::{Policy, Request, apply, usable_cores};
use runtime::statistics::Latencies;
use runtime::{
    ActiveProcess, Cause, Count, Figures, FromService, Group, Guest, Link, RELEASE_JITTER,
    RuntimeError, TakeOver, epoch, monotonic_ns, sleep_until, wait_word, wake_word,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use supervise::{Error, MachineError, UsageError};

/// Priority of a node whose file gives it none.
const PRIORITY: u8 = 80;
/// Longest wait before the loop shows that it lives, ns.
pub const LOOK_NS: i64 = 50_000_000;

/// Name of a node's counts.
pub fn counts_of(node: usize) -> String {
    format!("node{node}")
}

/// Counts of a node over all its processes.
pub struct NodeCounts {
    /// They show the turns of each process's loop.
    pub own: Figures,
    pub cycles: Count,
    /// Releases that were left out, because the node was busy or stopped.
    pub skipped: Count,
    /// Start of a cycle after its release.
    pub jitter: Latencies,
    /// Start of a cycle to its end.
    pub work: Latencies,
}

impl NodeCounts {
    /// The counts of a node; `node` is its place.
    pub fn open(node: usize, group: &Group) -> Result<Self, RuntimeError> {
        let own = Figures::open(group, counts_of(node))?;
        Ok(Self {
            cycles: own.count("cycles")?,
            skipped: own.count("skipped")?,
            jitter: own.latencies(RELEASE_JITTER)?,
            work: own.latencies("work")?,
            own,
        })
    }
}

/// A chain at this node.
struct Hop {
    chain: usize,
    /// Input that brings it here; none at the source.
    input: Option<usize>,
    /// Stamps so far; empty while no message has come.
    trail: Vec<i64>,
    /// The reactions of a chain that ends here.
    reactions: Option<Reactions>,
}

struct Process<'a> {
    of: &'a Node,
    node: usize,
    incarnation: u32,
    link: Link,
    page: Page,
    /// The triggers first.
    inputs: Vec<Input>,
    outputs: Vec<Output>,
    hops: Vec<Hop>,
    counts: NodeCounts,
    program: Option<Program>,
}

/// Runs a process of a node: `node` and `incarnation` are numbers.
pub fn run(root: &Path, node: &str, incarnation: &str) -> Result<ExitCode, Error> {
    runtime::log_warnings();
    let group = Group::read(root)?;
    // The launcher wrote it where a car's group has its scenario.
    let mistake = |why| UsageError::at("the group's file", why, "a graph of this program");
    let graph: Graph = serde_json::from_str(&group.scenario).map_err(mistake)?;
    let node = node.parse().ok().filter(|node| *node < graph.nodes.len());
    let (Some(node), Ok(incarnation)) = (node, incarnation.parse()) else {
        let expected = "a node of a graph";
        return Err(UsageError::at("timegap service node", "other arguments", expected).into());
    };
    let lived = live(&graph, node, incarnation, &group).map_err(|error| match error {
        Error::Runtime(error) => error,
        error => RuntimeError::Program(error.into()),
    });
    Ok(runtime::end_of_process(lived))
}

fn live(graph: &Graph, node: usize, incarnation: u32, group: &Group) -> Result<(), Error> {
    let guest = Guest::join(group, graph.nodes[node].name.as_str())?;
    let mut this = Process::open(graph, node, incarnation, group, &guest)?;
    let order = this.link.wait_for_start()?;
    match order.standby_for {
        Some(active) => this.stand_by(active)?,
        None if this.of.standby && !epoch::claim(this.page.epoch(node), incarnation) => {
            return Err(RuntimeError::Replaced.into());
        }
        None => {}
    }
    this.cycles(order.start_ns)
}

/// The scheduling of a node. Without a core of its own it shares the last one that this process may use.
pub fn request(graph: &Graph, node: &Node) -> Request {
    let policy = match graph.scheduling {
        bench::setup::Scheduling::Fifo => {
            Policy::Fifo(node.priority.map_or(PRIORITY, |priority| priority.value()))
        }
        bench::setup::Scheduling::Other => Policy::Other,
    };
    let core = node.core.map(|core| core.value().into()).or(usable_cores().last().copied());
    Request { policy, core, lock_memory: true }
}

impl<'a> Process<'a> {
    /// Opens all that the node needs, and says that it is ready.
    fn open(
        graph: &'a Graph,
        node: usize,
        incarnation: u32,
        group: &Group,
        guest: &Guest,
    ) -> Result<Self, Error> {
        let of = &graph.nodes[node];
        let inputs = of.inputs().map(|topic| Input::open(graph, topic, group, guest));
        let inputs: Vec<Input> = inputs.collect::<Result<_, _>>()?;
        let outputs = of.publishes.iter().map(|topic| Output::open(graph, topic, group, guest));
        let outputs = outputs.collect::<Result<_, _>>()?;
        let mut hops = Vec::new();
        for (chain, path) in graph.chains.iter().map(|chain| &chain.path).enumerate() {
            let Some(place) = path.iter().position(|name| name == of.name.as_str()) else {
                continue;
            };
            let topic = place.checked_sub(1).and_then(|before| graph.link(chain, before));
            let input = topic.and_then(|topic| inputs.iter().position(|one| one.topic == *topic));
            let ends = place + 1 == path.len();
            let reactions = ends.then(|| Reactions::open(graph, chain, group)).transpose()?;
            hops.push(Hop { chain, input, trail: Vec::new(), reactions });
        }
        let mut counts = NodeCounts::open(node, group)?;
        counts.own.begin(incarnation);
        let (page, link, request) = (Page::map(group)?, Link::open()?, request(graph, of));
        let granted = apply(&request);
        let program = of.program.as_ref().map(|command| Program::start(command, request.policy));
        let program = program.transpose()?;
        link.send(FromService::Ready(granted))?;
        Ok(Self { of, node, incarnation, link, page, inputs, outputs, hops, counts, program })
    }

    /// Shows that the loop lives, by a number that grows; false once the run is over.
    fn turn(&self) -> bool {
        self.counts.own.show_progress(monotonic_ns().unsigned_abs());
        !self.link.is_over()
    }

    /// Stands by until `active` ends, and takes the node over. The launcher kills an active process that hangs.
    fn stand_by(&mut self, active: ActiveProcess) -> Result<(), Error> {
        let look = Timespec { tv_sec: 0, tv_nsec: LOOK_NS / 4 };
        let pidfd =
            Pid::from_raw(active.pid).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        // One that has no pidfd was gone before.
        while let Some(pidfd) = &pidfd
            && !matches!(poll(&mut [PollFd::new(pidfd, PollFlags::IN)], Some(&look)), Ok(1..))
        {
            if !self.turn() {
                return Err(RuntimeError::Stopped.into());
            }
        }
        let noticed_ns = monotonic_ns();
        if !epoch::take_over(self.page.epoch(self.node), active.incarnation, self.incarnation) {
            return Err(RuntimeError::Replaced.into());
        }
        let took_over = TakeOver { cause: Cause::Gone, noticed_ns, sent_ns: monotonic_ns() };
        Ok(self.link.send(FromService::TookOver(took_over))?)
    }

    /// Runs cycles until the run is over.
    fn cycles(&mut self, start_ns: i64) -> Result<(), Error> {
        let (mut idle_ns, mut timer_ns) = (monotonic_ns(), None);
        if let Some(period_ns) = self.of.period_ns() {
            // A process that comes later goes on in the same grid.
            let periods = ((idle_ns - start_ns).max(0) + period_ns - 1) / period_ns;
            timer_ns = Some(start_ns + periods * period_ns);
        }
        while self.turn() {
            let seen = self.page.wake(self.node).load(Ordering::Acquire);
            for input in &mut self.inputs {
                input.take(&self.page, start_ns)?;
            }
            if let Some(due_ns) = self.released_ns(&mut timer_ns) {
                self.cycle(start_ns, [due_ns, idle_ns])?;
                idle_ns = monotonic_ns();
            } else {
                self.wait(seen, timer_ns)?;
            }
        }
        Ok(())
    }

    /// The release that is due: of the timer, which moves on, or the publication by which each trigger has a new
    /// message.
    fn released_ns(&mut self, timer_ns: &mut Option<i64>) -> Option<i64> {
        let (Some(period_ns), Some(timer_ns)) = (self.of.period_ns(), timer_ns) else {
            let triggers = &self.inputs[..self.of.trigger.len()];
            let all = triggers.iter().all(|input| input.arrived > input.used);
            return triggers.iter().map(|input| input.sent_ns).max().filter(|_| all);
        };
        // Whole periods that were missed are left out.
        let missed = (monotonic_ns() - *timer_ns).div_euclid(period_ns);
        (missed >= 0).then(|| {
            self.counts.skipped.add(missed.unsigned_abs());
            *timer_ns += (missed + 1) * period_ns;
            *timer_ns - period_ns
        })
    }

    /// One cycle, due and waited for since these instants.
    fn cycle(&mut self, run_ns: i64, [due_ns, idle_ns]: [i64; 2]) -> Result<(), Error> {
        let start_ns = monotonic_ns();
        self.inputs.iter_mut().for_each(Input::use_newest);
        for hop in &mut self.hops {
            hop.trail.clear();
            match hop.input.map(|input| &self.inputs[input]) {
                None => hop.trail.push(due_ns),
                Some(input) => input.layout.trail(&input.newest, hop.chain, &mut hop.trail),
            }
            if !hop.trail.is_empty() {
                // The end is stamped with each publication.
                hop.trail.extend([due_ns, idle_ns, start_ns, start_ns]);
            }
        }
        self.counts.cycles.add(1);
        let cycle = self.counts.cycles.get();
        if let Some(program) = &mut self.program {
            let came = self.inputs.iter().filter(|input| input.arrived > 0);
            let inputs: Vec<_> = came.map(|input| input.question(start_ns)).collect();
            program.ask(&json!({"node": self.of.name, "cycle": cycle, "inputs": inputs}))?;
        } else {
            spin_for(self.of.load_ns());
        }
        if self.of.standby && !epoch::is_present(self.page.epoch(self.node), self.incarnation) {
            return Err(RuntimeError::Replaced.into());
        }
        let mut outputs = self.outputs.iter_mut();
        let end_ns = loop {
            let end_ns = monotonic_ns();
            for end in self.hops.iter_mut().filter_map(|hop| hop.trail.last_mut()) {
                *end = end_ns;
            }
            let Some(output) = outputs.next() else { break end_ns };
            let mut header = Header::new(cycle, due_ns, Origins::NONE);
            (header.publish_ns, header.incarnation) = (end_ns, self.incarnation);
            let of = |chain| self.hops.iter().find(|hop| hop.chain == chain);
            output.send(header, |chain| of(chain).map_or(&[], |hop| &hop.trail))?;
            output.releases.iter().for_each(|reader| wake_word(self.page.wake(*reader)));
        };
        for hop in self.hops.iter_mut().filter(|hop| !hop.trail.is_empty()) {
            if let Some(reactions) = &mut hop.reactions {
                reactions.count(&hop.trail, (run_ns, end_ns));
            }
        }
        self.counts.jitter.record_ns(start_ns - due_ns);
        self.counts.work.record_ns(end_ns - start_ns);
        Ok(())
    }

    /// Waits for the next release.
    fn wait(&self, seen: u32, timer_ns: Option<i64>) -> Result<(), MachineError> {
        let now_ns = monotonic_ns();
        let delayed = self.inputs.iter().filter_map(|input| Some(input.delayed.front()?.0));
        let until_ns = delayed.chain(timer_ns).min().unwrap_or(i64::MAX).min(now_ns + LOOK_NS);
        if timer_ns.is_some() {
            sleep_until(until_ns);
            return Ok(());
        }
        let timeout = Duration::from_nanos((until_ns - now_ns).max(0).unsigned_abs());
        let waited = wait_word(self.page.wake(self.node), seen, timeout);
        waited.map_err(MachineError::cannot("wait for a message"))
    }
}
