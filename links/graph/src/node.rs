//! The process of a node: its ports, its releases, its cycles.
//!
//! ```text
//! ports open ─ ready ─ start ─┬─► take what came ─► a callback is due? ─► work ─► publish, wake readers ─┐
//!                             │                     none: sleep to the next timer, or until woken        │
//!                             └──────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! A standby has its ports open and waits. It takes the node's epoch when the active process ends or makes no progress.

use crate::load::Work;
use crate::page::Page;
use crate::plan::Graph;
use crate::ports::{Input, Output};
use crate::times::{NodeCounts, Reactions};
use messages::{Header, Origins};
use runtime::scheduling::{Granted, Policy, Request, apply, usable_cores};
use runtime::{
    ActiveProcess, Cause, CycleWatch, FromService, Group, Guest, Link, RuntimeError, TakeOver,
    epoch, monotonic_ns, sleep_until, wait_word, wake_word,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use supervise::{Error, UsageError};

/// Longest wait before the loop shows that it lives.
pub const LOOK_NS: i64 = 50_000_000;
/// Exit status of a process that another one replaced.
const REPLACED: u8 = 3;

/// One callback of the node.
#[derive(Debug)]
struct Callback {
    /// Next release of its timer, ns.
    due_ns: Option<i64>,
    /// Messages of each input that it has used.
    used: Vec<u64>,
    /// Chains through it.
    hops: Vec<Hop>,
}

/// A chain at this node.
#[derive(Debug)]
struct Hop {
    chain: usize,
    /// Input that brings it here, and the place of its trail in a message; none at the source.
    input: Option<(usize, std::ops::Range<usize>)>,
    /// Stamps so far; empty while no message has come.
    trail: Vec<i64>,
    /// The reactions of a chain that ends here.
    reactions: Option<Reactions>,
}

struct Process<'a> {
    graph: &'a Graph,
    node: usize,
    incarnation: u32,
    link: Link,
    page: Page,
    inputs: Vec<Input>,
    outputs: Vec<Output>,
    callbacks: Vec<Callback>,
    counts: NodeCounts,
    work: Work,
    idle_ns: i64,
    start_ns: i64,
    /// Turns of its loops, by which others see that it lives.
    turns: u64,
}

/// Runs a process of a node. `arguments` are the run's root, the node and the incarnation.
pub fn run(root: &Path, node: &str, incarnation: &str) -> Result<ExitCode, Error> {
    let not_one = || UsageError::at("timegap service node", "other arguments", "a node of a graph");
    let parsed = node.parse::<usize>().ok().zip(incarnation.parse::<u32>().ok());
    let (node, incarnation) = parsed.ok_or_else(not_one)?;
    runtime::log_warnings();
    let graph = Graph::read(root)?;
    if node >= graph.nodes.len() {
        return Err(not_one().into());
    }
    let group = Group::read(root)?;
    let guest = Guest::join(group.clone(), &graph.nodes[node].name)?;
    match live(&graph, node, incarnation, &group, &guest) {
        Ok(code) => Ok(code),
        Err(error) => {
            let line = serde_json::to_string(&FromService::Failed(error.to_string()));
            println!("{}", line.expect("a string is plain data"));
            Ok(ExitCode::FAILURE)
        }
    }
}

fn live(
    graph: &Graph,
    node: usize,
    incarnation: u32,
    group: &Group,
    guest: &Guest,
) -> Result<ExitCode, Error> {
    let (mut this, granted) = Process::open(graph, node, incarnation, group, guest)?;
    this.link.send(FromService::Ready(granted))?;
    let order = match this.link.wait_for_start() {
        Ok(order) => order,
        Err(RuntimeError::Stopped) => return Ok(ExitCode::SUCCESS),
        Err(error) => return Err(error.into()),
    };
    let speaks = match order.standby_for {
        Some(active) => this.stand_by(active, group)?,
        None => !graph.nodes[node].standby || epoch::claim(this.page.epoch(node), incarnation),
    };
    if !speaks {
        return Ok(ExitCode::from(if this.link.is_over() { 0 } else { REPLACED }));
    }
    let goes_on = this.cycles(order.start_ns)?;
    Ok(ExitCode::from(if goes_on { 0 } else { REPLACED }))
}

/// The scheduling that a node asks for. Without a core of its own it shares the last one that this process may use.
pub fn request(graph: &Graph, node: usize) -> Request {
    let of = &graph.nodes[node];
    Request {
        policy: match graph.scheduling {
            bench::setup::Scheduling::Fifo => Policy::Fifo(of.priority),
            bench::setup::Scheduling::Other => Policy::Other,
        },
        core: of.core.or(usable_cores().last().copied()),
        lock_memory: true,
    }
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
        let mut inputs: Vec<Input> = Vec::new();
        for topic in of.callbacks.iter().flat_map(|callback| &callback.reads) {
            if inputs.iter().all(|input| input.topic != *topic) {
                inputs.push(Input::open(graph, *topic, node, group, guest)?);
            }
        }
        let mut outputs = Vec::new();
        for topic in of.callbacks.iter().flat_map(|callback| &callback.publishes) {
            outputs.push(Output::open(graph, *topic, group, guest)?);
        }
        let mut callbacks = Vec::new();
        for number in 0..of.callbacks.len() {
            let used = vec![0; of.callbacks[number].reads.len()];
            let mut hops = Vec::new();
            for (chain, path) in graph.chains.iter().enumerate() {
                let is_here = |hop: &crate::plan::Hop| hop.node == node && hop.callback == number;
                let Some(place) = path.path.iter().position(is_here) else { continue };
                let input = path.path[place].topic.map(|topic| {
                    let input = inputs.iter().position(|input| input.topic == topic);
                    let trail = crate::trail::place(&graph.topics[topic], chain);
                    (input.expect("it is read"), trail.expect("the chain goes over it"))
                });
                let reactions = (place + 1 == path.path.len())
                    .then(|| Reactions::open(graph, chain, group))
                    .transpose()?;
                hops.push(Hop { chain, input, trail: Vec::with_capacity(256), reactions });
            }
            callbacks.push(Callback { due_ns: None, used, hops });
        }
        let link = Link::open()?;
        let granted = apply(&request(graph, node));
        let this = Self {
            graph,
            node,
            incarnation,
            link,
            page: Page::map(group)?,
            inputs,
            outputs,
            callbacks,
            counts: NodeCounts::open(node, Some(incarnation), group)?,
            work: Work::of(of, granted.granted == granted.requested)?,
            idle_ns: 0,
            start_ns: 0,
            turns: 0,
        };
        Ok((this, granted))
    }

    /// Stands by for `active`; true once this process has the node, false if it is not to have it.
    fn stand_by(&mut self, active: ActiveProcess, group: &Group) -> Result<bool, Error> {
        let load_ns = self.graph.nodes[self.node].callbacks.iter().map(|c| c.load_ns).max();
        let period_ns = LOOK_NS + 2 * load_ns.unwrap_or_default();
        let timeout_ms = scenario::supervision::Supervision::default().standby_timeout_ms;
        let timeout_ns = timeout_ms.nanoseconds().cast_signed();
        let mut watch = CycleWatch::new(monotonic_ns(), period_ns, timeout_ns);
        let progress = NodeCounts::progress(self.node, active.incarnation, group);
        let pidfd =
            Pid::from_raw(active.pid).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        let look = Timespec { tv_sec: 0, tv_nsec: timeout_ns / 4 };
        let cause = loop {
            if self.link.is_over() {
                return Ok(false);
            }
            self.turn();
            // One that has no pidfd was gone before.
            let Some(pidfd) = &pidfd else { break Cause::Gone };
            if matches!(poll(&mut [PollFd::new(pidfd, PollFlags::IN)], Some(&look)), Ok(1..)) {
                break Cause::Gone;
            }
            let cycles = progress.as_ref().map_or(0, runtime::Progress::cycles);
            if watch.is_silent(monotonic_ns(), cycles) {
                break Cause::Silent;
            }
        };
        let noticed_ns = monotonic_ns();
        let word = self.page.epoch(self.node);
        let took = epoch::take_over(word, active.incarnation, self.incarnation);
        if took {
            let take_over = TakeOver { cause, noticed_ns, sent_ns: monotonic_ns() };
            self.link.send(FromService::TookOver(take_over))?;
        }
        Ok(took)
    }

    /// Runs cycles until the run is over; false if another process has the node.
    fn cycles(&mut self, start_ns: i64) -> Result<bool, Error> {
        self.start_ns = start_ns;
        let now_ns = monotonic_ns();
        for (callback, of) in self.callbacks.iter_mut().zip(&self.graph.nodes[self.node].callbacks)
        {
            // A process that comes later goes on in the same grid.
            callback.due_ns = of.period_ns.map(|period_ns| {
                let missed = (now_ns - start_ns).max(0) as u64;
                start_ns + missed.div_ceil(period_ns.unsigned_abs()).cast_signed() * period_ns
            });
        }
        self.idle_ns = now_ns;
        while !self.link.is_over() {
            self.turn();
            let seen = self.page.wake(self.node).load(Ordering::Acquire);
            for input in &mut self.inputs {
                input.take(self.graph, &self.page, start_ns)?;
            }
            let now_ns = monotonic_ns();
            match self.due(now_ns) {
                Some((callback, due_ns)) => {
                    if !self.cycle(callback, due_ns)? {
                        return Ok(false);
                    }
                    self.idle_ns = monotonic_ns();
                }
                None => self.wait(seen, now_ns)?,
            }
        }
        Ok(true)
    }

    /// Shows that the loop lives.
    fn turn(&mut self) {
        self.turns += 1;
        self.counts.show_progress(self.turns);
    }

    /// The callback that was released first, with its release.
    fn due(&mut self, now_ns: i64) -> Option<(usize, i64)> {
        let released = (0..self.callbacks.len()).filter_map(|number| {
            let release_ns = self.callbacks[number].due_ns.map_or_else(
                || self.triggered_ns(number),
                |due_ns| Some(due_ns).filter(|due_ns| *due_ns <= now_ns),
            );
            Some((number, release_ns?))
        });
        let (number, release_ns) = released.min_by_key(|(_, release_ns)| *release_ns)?;
        let Some(period_ns) = self.graph.nodes[self.node].callbacks[number].period_ns else {
            return Some((number, release_ns));
        };
        // Whole periods that were missed are left out.
        let missed = (now_ns - release_ns) / period_ns;
        self.counts.skipped.add(missed.unsigned_abs());
        let release_ns = release_ns + missed * period_ns;
        self.callbacks[number].due_ns = Some(release_ns + period_ns);
        Some((number, release_ns))
    }

    /// Publication of the message by which each trigger of a callback has a new one, ns.
    fn triggered_ns(&self, number: usize) -> Option<i64> {
        let of = &self.graph.nodes[self.node].callbacks[number];
        let mut triggers = of.trigger.iter().zip(&self.callbacks[number].used);
        triggers.try_fold(0, |latest_ns: i64, (topic, used)| {
            let input = self.inputs.iter().find(|input| input.topic == *topic)?;
            (input.arrived > *used).then(|| latest_ns.max(input.sent_ns))
        })
    }

    /// One cycle; false if another process has the node.
    fn cycle(&mut self, number: usize, due_ns: i64) -> Result<bool, Error> {
        let start_ns = monotonic_ns();
        let (graph, node) = (self.graph, self.node);
        let of = &graph.nodes[node].callbacks[number];
        let callback = &mut self.callbacks[number];
        for (topic, used) in of.reads.iter().zip(&mut callback.used) {
            let found = self.inputs.iter_mut().find(|input| input.topic == *topic);
            let input = found.expect("all that is read is open");
            input.counts.unused.add((input.arrived - *used).saturating_sub(1));
            *used = input.arrived;
        }
        for hop in &mut callback.hops {
            hop.trail.clear();
            let begun = match &hop.input {
                None => {
                    hop.trail.push(due_ns);
                    true
                }
                Some((input, place)) => {
                    let message = &self.inputs[*input].newest;
                    message
                        .get(place.clone())
                        .is_some_and(|b| crate::trail::stamps(b, &mut hop.trail))
                }
            };
            if begun {
                hop.trail.extend([due_ns, self.idle_ns, start_ns]);
            } else {
                hop.trail.clear();
            }
        }
        let (cycle, name) = (self.counts.cycles.get() + 1, &graph.nodes[node].name);
        let inputs = &self.inputs;
        self.work
            .run(of.load_ns, || crate::ports::question(graph, name, cycle, inputs, start_ns))?;
        if graph.nodes[node].standby && !epoch::may_send(self.page.epoch(node), self.incarnation) {
            return Ok(false);
        }
        let mut end_ns = monotonic_ns();
        for topic in &of.publishes {
            let found = self.outputs.iter_mut().find(|output| output.topic == *topic);
            let output = found.expect("all that is published is open");
            end_ns = monotonic_ns();
            let mut header = Header::new(cycle, due_ns, Origins::NONE);
            (header.publish_ns, header.incarnation) = (end_ns, self.incarnation);
            for hop in callback.hops.iter_mut().filter(|hop| !hop.trail.is_empty()) {
                // Every topic has the instant of its own publication.
                let stamped = hop.trail.len() % crate::trail::STAMPS == 1;
                hop.trail.truncate(hop.trail.len() - usize::from(stamped));
                hop.trail.push(end_ns);
            }
            let trails = callback.hops.iter().map(|hop| (hop.chain, hop.trail.as_slice()));
            output.send(graph, header, trails)?;
            for reader in &graph.topics[*topic].releases {
                wake_word(self.page.wake(*reader));
            }
        }
        for hop in &mut callback.hops {
            if let Some(reactions) = hop.reactions.as_mut().filter(|_| !hop.trail.is_empty()) {
                if hop.trail.len() % crate::trail::STAMPS != 1 {
                    hop.trail.push(end_ns);
                }
                reactions.count(&hop.trail, (self.start_ns, end_ns), &self.page);
            }
        }
        self.counts.cycle(start_ns - due_ns, end_ns - start_ns);
        Ok(true)
    }

    /// Waits for the next release.
    fn wait(&self, seen: u32, now_ns: i64) -> Result<(), Error> {
        let timers = self.callbacks.iter().filter_map(|callback| callback.due_ns);
        let delayed = self.inputs.iter().filter_map(Input::delayed_until_ns);
        let until_ns = timers.chain(delayed).min().unwrap_or(i64::MAX).min(now_ns + LOOK_NS);
        if self.callbacks.iter().all(|callback| callback.due_ns.is_some()) {
            sleep_until(until_ns);
            return Ok(());
        }
        let timeout = Duration::from_nanos((until_ns - now_ns).max(0).unsigned_abs());
        wait_word(self.page.wake(self.node), seen, timeout)
            .map_err(supervise::MachineError::cannot("wait for a message"))?;
        Ok(())
    }
}
