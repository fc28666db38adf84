//! The nodes as a process group: the car's supervision ([`Roster`]), with faults of a graph.

use crate::node::LOOK_NS;
use crate::plan::{Fault, Graph};
use crate::times::{self, NodeCounts};
use bench::setup::Scheduling;
use bench::stage::Stage;
use runtime::scheduling::Priority;
use runtime::{Figures, FromService, Group, Guest, monotonic_ns};
use rustix::process::Signal;
use scenario::supervision::Supervision;
use std::fmt;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use supervise::succession::{self, Phase, Step};
use supervise::{Error, Event, FaultLog, MachineError, Role, Roster, follow_signals};

/// Time in which all nodes must be ready.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time between readiness and the common start, ns.
const START_DELAY_NS: i64 = 50_000_000;
/// Time in which a process that was started during the run must be ready, ns.
const RESTART_NS: i64 = 5_000_000_000;
/// Time that a process gets to leave.
const GRACE: Duration = Duration::from_secs(2);
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
        Figures::of(group, times::counts_of(self.place))
    }
}

pub struct Launcher<'a> {
    graph: &'a Graph,
    pub roster: Roster<'a, Seat>,
    guest: Guest,
    seats: Vec<Seat>,
    pub counts: Vec<NodeCounts>,
    pub log: FaultLog<Seat>,
    /// Why the run ended early.
    pub broken: Option<String>,
    /// Begin and end of each fault were acted on.
    acted: Vec<[bool; 2]>,
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
            acted: vec![[false; 2]; graph.faults.len()],
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

    /// Waits until all processes are ready, and gives them the common start.
    pub fn begin(&mut self) -> Result<(), Error> {
        let not_ready = |node, what| MachineError(format!("node {node} {what}")).into();
        self.roster.wait_until_ready(Instant::now(), PATIENCE, not_ready)?;
        self.roster.begin_all(monotonic_ns() + START_DELAY_NS);
        Ok(())
    }

    /// Follows the run until its end. `watch` gets the run time, ns.
    pub fn run(&mut self, mut watch: impl FnMut(i64)) -> Result<(), Error> {
        let length_ns = self.graph.duration_s.nanoseconds().cast_signed();
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
                if !self.roster.is_taken_over(who, told, &mut self.log) {
                    return Ok(());
                }
                (who, succession::Event::TookOver(who.incarnation))
            }
            Event::Gone(who) => {
                let is_active = self.roster.is_active(who);
                let settled = self.roster.of(who.role).settle(who.incarnation);
                let Some((exit, _)) = settled else { return Ok(()) };
                if is_active {
                    let (next, now_ns) = (who.incarnation + 1, self.roster.now_ns());
                    self.log.detected(who.role, "died", next, None, now_ns);
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
        let timeout_ns = Supervision::default().heartbeat_timeout_ms.nanoseconds().cast_signed();
        let limit_ns = |seat: Seat| {
            let node = &graph.nodes[seat.place];
            let program_ns = node.program.as_ref().map_or(0, |_| PROGRAM_NS);
            timeout_ns + LOOK_NS + 2 * node.load_ns() + program_ns
        };
        roster.kill_the_hung(roster.now_ns(), limit_ns, log);
        for seat in self.seats.clone() {
            self.roster.kill_the_late(seat, self.roster.now_ns(), RESTART_NS);
            self.follow(seat, succession::Event::Tick)?;
            let (now_ns, member) = (self.roster.now_ns(), self.roster.of(seat));
            let now = (member.incarnation(), self.counts[seat.place].cycles.get());
            let seen = &mut self.seen[seat.place];
            if member.phase() != Phase::Running || (now.0 != seen.0 && now.1 == seen.1) {
                continue;
            }
            if now.0 != seen.0 {
                self.log.recovered(seat, now.0, now_ns);
            }
            *seen = now;
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
        for (fault, acted) in self.graph.faults.iter().zip(&mut self.acted) {
            let (now_ns, (from_ns, to_ns)) = (self.roster.now_ns(), fault.span_ns());
            let due = [now_ns >= from_ns, now_ns >= to_ns];
            let [begins, ends] = [0, 1].map(|at| due[at] && !acted[at]);
            *acted = due;
            let seat = fault.node().and_then(|name| self.graph.node(name));
            let seat = seat.map(|place| self.seats[place]);
            if let Some(seat) = seat {
                let process = self.roster.of(seat).process();
                match fault {
                    Fault::Kill { .. } if begins => process.kill(),
                    Fault::Stop { .. } if begins => process.signal(Signal::STOP),
                    Fault::Stop { .. } if ends => process.signal(Signal::CONT),
                    _ => {}
                }
            }
            let kind = match fault {
                Fault::Kill { .. } => "kill",
                Fault::Stop { .. } => "stop",
                // The readers know of delays.
                Fault::Delay { topic, .. } => &format!("delay {topic}"),
            };
            if begins {
                self.log.asked(kind, seat, now_ns);
            }
        }
    }

    /// Ends all processes.
    pub fn end(&mut self) {
        self.roster.end_all(GRACE);
    }
}
