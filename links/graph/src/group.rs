//! The nodes as a process group: the car's supervision ([`Roster`]), with faults of a graph.

use crate::node::{LOOK_NS, NodeCounts, counts_of};
use crate::plan::{Fault, Graph};
use bench::setup::Scheduling;
use bench::stage::Stage;
use runtime::scheduling::Priority;
use runtime::{Figures, FromService, Group, Guest, monotonic_ns};
use rustix::process::Signal;
use scenario::supervision::Supervision;
use std::cmp::Reverse;
use std::fmt;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use supervise::succession::{self, Phase, Step};
use supervise::{Error, Event, FaultLog, MachineError, Role, Roster, follow_signals};

/// Time in which all nodes must be ready.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time between readiness and the common start, ns.
const START_DELAY_NS: i64 = 50_000_000;
/// Longest time between two looks at the processes.
const LOOK: Duration = Duration::from_millis(1);
/// Further silence that a node's program may need, ns.
const PROGRAM_NS: i64 = 1_000_000_000;
/// Priority of the launcher, as in a car's group: below the nodes, above other programs.
const PRIORITY: u8 = 10;

/// A node by its place in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seat {
    place: usize,
    name: &'static str,
}

impl fmt::Display for Seat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Role for Seat {
    const IS_SEEN_BY_COUNTS: bool = true;

    fn words(self) -> Vec<String> {
        vec!["node".to_owned(), self.place.to_string()]
    }

    fn figures(self, group: &Group) -> Figures {
        Figures::of(group, counts_of(self.place))
    }
}

pub struct Launcher<'a> {
    pub graph: &'a Graph,
    pub roster: Roster<'a, Seat>,
    guest: Guest,
    seats: Vec<Seat>,
    pub counts: Vec<NodeCounts>,
    pub log: FaultLog<Seat>,
    /// Why the run ended early.
    pub broken: Option<String>,
    /// Begins and ends of faults that are to come, the next one last: run time in ns, and whether it is the end.
    due: Vec<(i64, bool, &'a Fault)>,
    /// The active process of each node at the last look, and the node's cycles.
    seen: Vec<(u32, u64)>,
    _priority: Option<Priority>,
}

impl<'a> Launcher<'a> {
    /// A launcher on a stage, before it starts anything.
    pub fn new(graph: &'a Graph, stage: &'a Stage) -> Result<Self, Error> {
        let mut group = Group::read(stage.root().path())?;
        group.scenario = serde_json::to_string(graph).expect("plain data");
        group.write()?;
        let counts = (0..graph.nodes.len()).map(|node| NodeCounts::open(node, &group));
        let (sender, events) = channel();
        follow_signals(sender.clone())?;
        let ends = |fault: &'a Fault| {
            let (from_ns, to_ns) = fault.span_ns();
            [(to_ns, true, fault), (from_ns, false, fault)]
        };
        let mut due: Vec<_> = graph.faults.iter().flat_map(ends).collect();
        due.sort_by_key(|(at_ns, ..)| Reverse(*at_ns));
        // Threads of the processes have the names to the end.
        let seat = |(place, name): (usize, String)| Seat { place, name: name.leak() };
        let names = graph.nodes.iter().map(|node| node.name.as_str().to_owned());
        Ok(Self {
            graph,
            guest: Guest::join(&group, "graph")?,
            seats: names.enumerate().map(seat).collect(),
            counts: counts.collect::<Result<_, _>>()?,
            roster: Roster::new(stage.root(), group, (sender, events))?,
            log: FaultLog::default(),
            broken: None,
            due,
            seen: vec![(0, 0); graph.nodes.len()],
            _priority: (graph.scheduling == Scheduling::Fifo).then(|| Priority::raise(PRIORITY)),
        })
    }

    /// Starts all processes.
    pub fn start(&mut self) -> Result<(), Error> {
        let policy = Supervision::default();
        for (seat, node) in self.seats.iter().zip(&self.graph.nodes) {
            self.roster.start(*seat, None, (&policy, policy.restart, node.standby))?;
        }
        Ok(())
    }

    /// Gives all processes the common start when they are ready, and follows the run until its end. `watch` gets the run
    /// time, ns.
    pub fn run(&mut self, mut watch: impl FnMut(i64)) -> Result<(), Error> {
        let not_ready = |node, what| MachineError(format!("node {node} {what}")).into();
        self.roster.wait_until_ready(Instant::now(), PATIENCE, not_ready)?;
        self.roster.begin_all(monotonic_ns() + START_DELAY_NS);
        let length_ns = self.graph.length_ns();
        while self.roster.now_ns() < length_ns && self.broken.is_none() {
            let event = self.roster.events.recv_timeout(LOOK);
            watch(self.roster.now_ns());
            event.map_or(Ok(()), |event| self.take(event))?;
            self.apply_faults();
            self.look()?;
        }
        watch(length_ns);
        Ok(())
    }

    fn take(&mut self, event: Event<Seat>) -> Result<(), Error> {
        let (who, event) = match event {
            Event::Message(who, FromService::Ready(_)) => {
                (who, succession::Event::Ready(who.incarnation))
            }
            Event::Message(who, FromService::TookOver(told)) => {
                self.roster.is_taken_over(who, told, &mut self.log);
                (who, succession::Event::TookOver(who.incarnation))
            }
            Event::Gone(who) => {
                let is_active = self.roster.is_active(who);
                let settled = self.roster.of(who.role).settle(who.incarnation);
                let Some((exit, _)) = settled else { return Ok(()) };
                if is_active {
                    let now_ns = self.roster.now_ns();
                    self.log.detected(who.role, "died", who.incarnation + 1, None, now_ns);
                }
                // There is room for the next process beside its dead self.
                self.guest.remove_dead();
                let (incarnation, failed) = (who.incarnation, exit.is_failure());
                (who, succession::Event::Gone { incarnation, failed })
            }
            Event::Message(who, FromService::Failed(line)) | Event::Output(who, line) => {
                report::print::note(&format!("note: {}: {line}", who.role));
                return Ok(());
            }
            Event::Signal => return Err(Error::Interrupted),
            _ => return Ok(()),
        };
        self.follow(who.role, event)
    }

    /// Looks at all nodes: processes that hang or are due, and recoveries.
    fn look(&mut self) -> Result<(), Error> {
        let Self { graph, roster, log, .. } = self;
        let policy = Supervision::default();
        // The standby sees the end of a process that is killed for its silence.
        let limit_ns = |seat: Seat| {
            let node = &graph.nodes[seat.place];
            let (alone, standby) = (policy.heartbeat_timeout_ms, policy.standby_timeout_ms);
            let timeout = if node.standby { standby } else { alone };
            let program_ns = node.program.as_ref().map_or(0, |_| PROGRAM_NS);
            timeout.nanoseconds().cast_signed() + LOOK_NS + 2 * node.load_ns() + program_ns
        };
        roster.kill_the_hung(roster.now_ns(), limit_ns, log);
        for seat in self.seats.clone() {
            let now_ns = self.roster.now_ns();
            self.roster.kill_the_late(seat, now_ns);
            self.follow(seat, succession::Event::Tick)?;
            let (member, seen) = (self.roster.of(seat), &mut self.seen[seat.place]);
            let (incarnation, cycles) =
                (member.incarnation(), self.counts[seat.place].cycles.get());
            if member.phase() == Phase::Running && incarnation != seen.0 && cycles != seen.1 {
                self.log.recovered(seat, incarnation, now_ns);
                seen.0 = incarnation;
            }
            if incarnation == seen.0 {
                seen.1 = cycles;
            }
        }
        Ok(())
    }

    fn follow(&mut self, seat: Seat, event: succession::Event) -> Result<(), Error> {
        let steps = self.roster.follow(seat, event, self.roster.now_ns())?;
        if steps.iter().any(|step| matches!(step, Step::GiveUp | Step::EndRun)) {
            self.broken = Some(format!("node {seat} ended too often"));
        }
        Ok(())
    }

    fn apply_faults(&mut self) {
        let now_ns = self.roster.now_ns();
        while let Some((_, is_end, fault)) = self.due.pop_if(|(at_ns, ..)| *at_ns <= now_ns) {
            let seat = fault.node().and_then(|name| self.graph.node(name));
            let seat = seat.map(|place| self.seats[place]);
            let (kind, signal) = match fault {
                Fault::Kill { .. } => ("kill", (!is_end).then_some(Signal::KILL)),
                Fault::Stop { .. } if is_end => ("stop", Some(Signal::CONT)),
                Fault::Stop { .. } => ("stop", Some(Signal::STOP)),
                // The readers know of delays.
                Fault::Delay { topic, .. } => (&*format!("delay {topic}"), None),
            };
            if !is_end {
                self.log.asked(kind, seat, now_ns);
            }
            if let (Some(seat), Some(signal)) = (seat, signal) {
                self.roster.of(seat).process().signal(signal);
            }
        }
    }
}
