//! The process of a node: its ports, its releases, its cycles.
//!
//! ```text
//! ports open ─ ready ─ start ─┬─► take what came ─► released? ─► work ─► publish, wake readers ─┐
//!                             │                     no: sleep to the timer, or until woken      │
//!                             └─────────────────────────────────────────────────────────────────┘
//! ```
//!
//! A standby has its ports open and waits. It takes the node's epoch when the active process ends or makes no progress.

use crate::load::{Program, spin_for};
use crate::plan::{Graph, Node, ns};
use crate::ports::{Input, Output};
use crate::times::{NodeCounts, Page, Reactions};
use messages::{Header, Origins};
use runtime::scheduling::{Granted, Policy, Request, apply, usable_cores};
use runtime::{
    ActiveProcess, Cause, CycleWatch, FromService, Group, Guest, Link, RuntimeError, TakeOver,
    epoch, monotonic_ns, sleep_until, wait_word, wake_word,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use scenario::supervision::Supervision;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use supervise::{Error, UsageError};

/// Longest wait before the loop shows that it lives, ns.
pub const LOOK_NS: i64 = 50_000_000;
/// Exit status of a process that another one replaced.
const REPLACED: u8 = 3;

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
    /// Turns of its loops, by which others see that it lives.
    turns: u64,
    program: Option<Program>,
    start_ns: i64,
    /// Next release of its timer, ns.
    due_ns: i64,
    idle_ns: i64,
}

/// Runs a process of a node: `node` and `incarnation` are numbers.
pub fn run(root: &Path, node: &str, incarnation: &str) -> Result<ExitCode, Error> {
    runtime::log_warnings();
    let group = Group::read(root)?;
    let graph = Graph::of(&group)?;
    let node = node.parse().ok().filter(|node| *node < graph.nodes.len());
    let (Some(node), Ok(incarnation)) = (node, incarnation.parse()) else {
        let expected = "a node of a graph";
        return Err(UsageError::at("timegap service node", "other arguments", expected).into());
    };
    let code = live(&graph, node, incarnation, &group);
    Ok(code.unwrap_or_else(|error| {
        let line = serde_json::to_string(&FromService::Failed(error.to_string()));
        println!("{}", line.expect("a string is plain data"));
        ExitCode::FAILURE
    }))
}

fn live(graph: &Graph, node: usize, incarnation: u32, group: &Group) -> Result<ExitCode, Error> {
    let guest = Guest::join(group, graph.nodes[node].name.as_str())?;
    let (mut this, granted) = Process::open(graph, node, incarnation, group, &guest)?;
    this.link.send(FromService::Ready(granted))?;
    let order = match this.link.wait_for_start() {
        Err(RuntimeError::Stopped) => return Ok(ExitCode::SUCCESS),
        order => order?,
    };
    let speaks = match order.standby_for {
        Some(active) => this.stand_by(active, group)?,
        None => !this.of.standby || epoch::claim(this.page.epoch(node), incarnation),
    };
    let goes_on = speaks && this.cycles(order.start_ns)?;
    Ok(ExitCode::from(if goes_on || this.link.is_over() { 0 } else { REPLACED }))
}

/// The scheduling of a node. Without a core of its own it shares the last one that this process may use.
pub fn request(graph: &Graph, node: &Node) -> Request {
    let policy = match graph.scheduling {
        bench::setup::Scheduling::Fifo => Policy::Fifo(node.priority.value()),
        bench::setup::Scheduling::Other => Policy::Other,
    };
    let core = node.core.map(|core| core.value().into()).or(usable_cores().last().copied());
    Request { policy, core, lock_memory: true }
}

impl<'a> Process<'a> {
    fn open(
        graph: &'a Graph,
        node: usize,
        incarnation: u32,
        group: &Group,
        guest: &Guest,
    ) -> Result<(Self, Granted), Error> {
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
        let (page, link) = (Page::map(group)?, Link::open()?);
        let granted = apply(&request(graph, of));
        let has_priority = granted.granted == granted.requested;
        let priority = has_priority.then(|| of.priority.value());
        let start = |command: &String| Program::start(command, priority);
        let program = of.program.as_ref().map(start).transpose()?;
        let (turns, start_ns, due_ns, idle_ns) = (0, 0, 0, 0);
        let this = Self {
            of,
            node,
            incarnation,
            link,
            page,
            inputs,
            outputs,
            hops,
            counts,
            turns,
            program,
            start_ns,
            due_ns,
            idle_ns,
        };
        Ok((this, granted))
    }

    /// Shows that the loop lives; false once the run is over.
    fn turn(&mut self) -> bool {
        self.turns += 1;
        self.counts.own.show_progress(self.turns);
        !self.link.is_over()
    }

    /// Stands by for `active`; true once this process has the node, false if it is not to have it.
    fn stand_by(&mut self, active: ActiveProcess, group: &Group) -> Result<bool, Error> {
        let timeout_ms = Supervision::default().standby_timeout_ms;
        let timeout_ns = timeout_ms.nanoseconds().cast_signed();
        let period_ns = LOOK_NS + 2 * self.of.load_ns();
        let mut watch = CycleWatch::new(monotonic_ns(), period_ns, timeout_ns);
        let progress = NodeCounts::open(self.node, group)?.own.progress(active.incarnation);
        let pidfd =
            Pid::from_raw(active.pid).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        let look = Timespec { tv_sec: 0, tv_nsec: timeout_ns / 4 };
        let cause = loop {
            if !self.turn() {
                return Ok(false);
            }
            // One that has no pidfd was gone before.
            let Some(pidfd) = &pidfd else { break Cause::Gone };
            if matches!(poll(&mut [PollFd::new(pidfd, PollFlags::IN)], Some(&look)), Ok(1..)) {
                break Cause::Gone;
            }
            let turns = progress.as_ref().map_or(0, runtime::Progress::cycles);
            if watch.is_silent(monotonic_ns(), turns) {
                break Cause::Silent;
            }
        };
        let noticed_ns = monotonic_ns();
        let word = self.page.epoch(self.node);
        let took = epoch::take_over(word, active.incarnation, self.incarnation);
        if took {
            let sent_ns = monotonic_ns();
            self.link.send(FromService::TookOver(TakeOver { cause, noticed_ns, sent_ns }))?;
        }
        Ok(took)
    }

    /// Runs cycles until the run is over; false if another process has the node.
    fn cycles(&mut self, start_ns: i64) -> Result<bool, Error> {
        self.idle_ns = monotonic_ns();
        (self.start_ns, self.due_ns) = (start_ns, start_ns);
        let period_ns = self.of.period_ms.map(ns);
        if let Some(period_ns) = period_ns {
            // A process that comes later goes on in the same grid.
            let missed = (self.idle_ns - start_ns).max(0).unsigned_abs();
            let periods = missed.div_ceil(period_ns.unsigned_abs());
            self.due_ns += periods.cast_signed() * period_ns;
        }
        while self.turn() {
            let seen = self.page.wake(self.node).load(Ordering::Acquire);
            for input in &mut self.inputs {
                input.take(&self.page, start_ns)?;
            }
            match self.released_ns(period_ns) {
                Some(release_ns) if !self.cycle(release_ns)? => return Ok(false),
                Some(_) => self.idle_ns = monotonic_ns(),
                None => self.wait(seen, period_ns.is_some())?,
            }
        }
        Ok(true)
    }

    /// The release that is due: of the timer, or the publication by which each trigger has a new message.
    fn released_ns(&mut self, period_ns: Option<i64>) -> Option<i64> {
        let Some(period_ns) = period_ns else {
            let triggers = &self.inputs[..self.of.trigger.len()];
            let is_new = |input: &Input| input.arrived > input.used;
            let all = triggers.iter().all(is_new);
            return triggers.iter().map(|input| input.sent_ns).max().filter(|_| all);
        };
        let late_ns = monotonic_ns() - self.due_ns;
        if late_ns < 0 {
            return None;
        }
        // Whole periods that were missed are left out.
        let missed = late_ns / period_ns;
        self.counts.skipped.add(missed.unsigned_abs());
        let release_ns = self.due_ns + missed * period_ns;
        self.due_ns = release_ns + period_ns;
        Some(release_ns)
    }

    /// One cycle; false if another process has the node.
    fn cycle(&mut self, due_ns: i64) -> Result<bool, Error> {
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
                hop.trail.extend([due_ns, self.idle_ns, start_ns, start_ns]);
            }
        }
        self.counts.cycles.add(1);
        let cycle = self.counts.cycles.get();
        if let Some(program) = &mut self.program {
            let came = self.inputs.iter().filter(|input| input.arrived > 0);
            let inputs: Vec<_> = came.map(|input| input.question(start_ns)).collect();
            let question = json!({"node": self.of.name.as_str(), "cycle": cycle, "inputs": inputs});
            program.ask(&question.to_string())?;
        } else {
            spin_for(self.of.load_ns());
        }
        if self.of.standby && !epoch::may_send(self.page.epoch(self.node), self.incarnation) {
            return Ok(false);
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
            output.send(header, |chain| of(chain).map(|hop| hop.trail.as_slice()))?;
            output.releases.iter().for_each(|reader| wake_word(self.page.wake(*reader)));
        };
        for hop in self.hops.iter_mut().filter(|hop| !hop.trail.is_empty()) {
            if let Some(reactions) = &mut hop.reactions {
                reactions.count(&hop.trail, (self.start_ns, end_ns), &self.page);
            }
        }
        self.counts.jitter.record_ns(start_ns - due_ns);
        self.counts.work.record_ns(end_ns - start_ns);
        Ok(true)
    }

    /// Waits for the next release.
    fn wait(&self, seen: u32, has_timer: bool) -> Result<(), Error> {
        let now_ns = monotonic_ns();
        let timer = has_timer.then_some(self.due_ns);
        let delayed = self.inputs.iter().filter_map(Input::delayed_until_ns);
        let until_ns = delayed.chain(timer).min().unwrap_or(i64::MAX).min(now_ns + LOOK_NS);
        if has_timer {
            sleep_until(until_ns);
            return Ok(());
        }
        let timeout = Duration::from_nanos((until_ns - now_ns).max(0).unsigned_abs());
        let word = self.page.wake(self.node);
        let failed = supervise::MachineError::cannot("wait for a message");
        Ok(wait_word(word, seen, timeout).map_err(failed)?)
    }
}
