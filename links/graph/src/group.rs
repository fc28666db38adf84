//! The nodes as a process group: start, faults, supervision, end. Each node has the car's succession of processes.

use crate::node::LOOK_NS;
use crate::plan::{Fault, Graph};
use crate::times::NodeCounts;
use bench::setup::Scheduling;
use bench::stage::Stage;
use runtime::scheduling::{Granted, Priority};
use runtime::{
    ActiveProcess, FromService, Group, Guest, Progress, StartOrder, ToService, monotonic_ns,
};
use scenario::supervision::Supervision;
use serde::Serialize;
use std::ffi::OsStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use supervise::succession::{Event, Phase, Standby, Step, Succession};
use supervise::{Attendant, Error, Exit, MachineError, Meaning, Share, Silence};

/// Time in which all nodes must be ready.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time between readiness and the common start, ns.
const START_DELAY_NS: i64 = 50_000_000;
/// Time in which a process that was started during the run must be ready, ns.
const RESTART_NS: i64 = 5_000_000_000;
/// Time that a process gets to leave.
const GRACE: Duration = Duration::from_secs(2);
/// Time between two looks at the processes.
const LOOK: Duration = Duration::from_millis(1);
/// Further silence that a node's program may need, ns.
const PROGRAM_NS: i64 = 1_000_000_000;
/// Priority of the launcher, as in a car's group: below the nodes, above other programs.
const PRIORITY: u8 = 10;

/// A fault that was asked for, or an end or silence that was not.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// Run time of its begin, s.
    pub t_s: f64,
    /// `kill camera`, `stop camera`, `delay image`; `died` and `hung` were not asked for.
    pub fault: String,
    /// Time until the launcher or the standby noticed it, µs.
    pub detected_after_us: Option<f64>,
    /// Time until the first cycle of the next process, µs.
    pub recovered_after_us: Option<f64>,
    /// `restart` or `take-over`.
    pub recovered_by: Option<&'static str>,
    #[serde(skip)]
    node: Option<usize>,
    /// The process that is gone or hangs, and cycles of the node when that was noticed.
    #[serde(skip)]
    awaits: Option<(u32, u64)>,
}

struct Process {
    incarnation: u32,
    attendant: Attendant,
    silence: Silence,
    progress: Option<Progress>,
    /// Its end was noted.
    is_settled: bool,
}

pub struct Member {
    pub succession: Succession,
    pub counts: NodeCounts,
    pub granted: Option<Granted>,
    /// Time for which it waited for the processor, ms.
    pub starved_ms: f64,
    processes: Vec<Process>,
    /// Longest silence of its loop, ns.
    limit_ns: i64,
}

impl Member {
    fn process(&mut self, incarnation: u32) -> Option<&mut Process> {
        self.processes.iter_mut().find(|process| process.incarnation == incarnation)
    }

    fn active(&mut self) -> Option<&mut Process> {
        self.process(self.succession.active())
    }
}

pub struct Launcher<'a> {
    graph: &'a Graph,
    stage: &'a Stage,
    pub group: Group,
    guest: Guest,
    pub members: Vec<Member>,
    pub records: Vec<Record>,
    /// Why the run ended early.
    pub broken: Option<String>,
    /// Begin and end of each fault were acted on.
    acted: Vec<[bool; 2]>,
    /// Process group of the nodes.
    leader: i32,
    start_ns: i64,
    _priority: Option<Priority>,
}

impl<'a> Launcher<'a> {
    /// Starts all processes.
    pub fn start(graph: &'a Graph, stage: &'a Stage) -> Result<Self, Error> {
        let group = Group::read(stage.root().path())?;
        graph.write(stage.root().path())?;
        let guest = Guest::join(&group, "graph")?;
        let policy = Supervision::default();
        let timeout_ns = policy.heartbeat_timeout_ms.nanoseconds().cast_signed();
        let mut members = Vec::new();
        for (index, node) in graph.nodes.iter().enumerate() {
            let program_ns = node.program.as_ref().map_or(0, |_| PROGRAM_NS);
            members.push(Member {
                succession: Succession::new(&policy, policy.restart, node.standby),
                counts: NodeCounts::open(index, &group)?,
                granted: None,
                starved_ms: 0.0,
                processes: Vec::new(),
                limit_ns: timeout_ns + LOOK_NS + 2 * node.load_ns() + program_ns,
            });
        }
        let mut this = Self {
            graph,
            stage,
            group,
            guest,
            members,
            records: Vec::new(),
            broken: None,
            acted: vec![[false; 2]; graph.faults.len()],
            leader: 0,
            start_ns: 0,
            _priority: (graph.scheduling == Scheduling::Fifo).then(|| Priority::raise(PRIORITY)),
        };
        for (node, of) in graph.nodes.iter().enumerate() {
            (0..=u32::from(of.standby))
                .try_for_each(|incarnation| this.spawn(node, incarnation))?;
        }
        stage.watch(this.leader);
        Ok(this)
    }

    fn spawn(&mut self, node: usize, incarnation: u32) -> Result<(), Error> {
        // A process group ends with its last process.
        let mut all = self.members.iter_mut().flat_map(|member| &mut member.processes);
        if all.all(|process| process.attendant.is_gone()) {
            self.leader = 0;
        }
        let words = [node.to_string(), incarnation.to_string()];
        let words = words.each_ref().map(OsStr::new);
        let (name, root) = (self.graph.nodes[node].name.as_str(), self.stage.root());
        let attendant = Attendant::spawn_as(name, "node", &words, root, self.leader)?;
        if self.leader == 0 {
            self.leader = attendant.pid();
        }
        let silence = Silence::from(self.now_ns());
        let (progress, is_settled) = (None, false);
        let process = Process { incarnation, attendant, silence, progress, is_settled };
        self.members[node].processes.push(process);
        Ok(())
    }

    fn now_ns(&self) -> i64 {
        monotonic_ns() - self.start_ns
    }

    /// Waits until all processes are ready, and gives them the common start.
    pub fn begin(&mut self, interrupted: &AtomicBool) -> Result<(), Error> {
        let begun = Instant::now();
        for (node, member) in self.members.iter_mut().enumerate() {
            for process in &mut member.processes {
                loop {
                    let how = match process.attendant.receive(Duration::from_millis(20)) {
                        Some(FromService::Ready(granted)) => break member.granted = Some(granted),
                        Some(FromService::Failed(how)) => format!("fails: {how}"),
                        _ if interrupted.load(Ordering::Relaxed) => return Err(Error::Interrupted),
                        _ if process.attendant.is_gone() => "ended at once".to_owned(),
                        _ if begun.elapsed() > PATIENCE => "is not ready in time".to_owned(),
                        _ => continue,
                    };
                    let name = self.graph.nodes[node].name.as_str();
                    return Err(MachineError(format!("node {name} {how}")).into());
                }
            }
        }
        self.start_ns = monotonic_ns() + START_DELAY_NS;
        for (node, of) in self.graph.nodes.iter().enumerate() {
            (0..=u32::from(of.standby)).try_for_each(|one| self.follow(node, Event::Ready(one)))?;
        }
        Ok(())
    }

    /// Follows the run until its end. `watch` gets the run time, ns.
    pub fn run(
        &mut self,
        interrupted: &AtomicBool,
        mut watch: impl FnMut(i64),
    ) -> Result<(), Error> {
        let length_ns = self.graph.duration_s.nanoseconds().cast_signed();
        while self.now_ns() < length_ns && self.broken.is_none() {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            watch(self.now_ns());
            self.apply_faults();
            (0..self.members.len()).try_for_each(|node| self.look(node))?;
            std::thread::sleep(LOOK);
        }
        watch(length_ns);
        Ok(())
    }

    /// Looks at the processes of a node.
    fn look(&mut self, node: usize) -> Result<(), Error> {
        let (now_ns, mut events, mut hangs) = (self.now_ns(), Vec::new(), false);
        let member = &mut self.members[node];
        let (active, standby) = (member.succession.active(), member.succession.standby());
        for process in member.processes.iter_mut().filter(|process| !process.is_settled) {
            let incarnation = process.incarnation;
            while let Some(message) = process.attendant.receive(Duration::ZERO) {
                match message {
                    FromService::Ready(_) => events.push((Event::Ready(incarnation), now_ns)),
                    FromService::TookOver(told) => {
                        events
                            .push((Event::TookOver(incarnation), told.noticed_ns - self.start_ns));
                    }
                    FromService::Failed(how) => report::print::note(&format!("note: {how}")),
                    _ => {}
                }
            }
            if process.attendant.is_gone() {
                process.is_settled = true;
                let status = process.attendant.end(Duration::ZERO);
                let failed = status.is_none_or(|status| Exit::of(status).is_failure());
                events.push((Event::Gone { incarnation, failed }, now_ns));
                continue;
            }
            let works = incarnation == active && member.succession.phase == Phase::Running
                || standby == Standby::Ready { incarnation };
            process.progress =
                process.progress.take().or_else(|| member.counts.own.progress(incarnation));
            if let Some(progress) = &process.progress {
                process.silence.broken(progress.cycles(), now_ns);
            }
            let pid = process.attendant.pid();
            let limit_ns = if works { member.limit_ns } else { RESTART_NS };
            match process.silence.meaning(now_ns, limit_ns, || Share::of(pid)) {
                Meaning::Lives => {}
                Meaning::Starved(silent_ns) => member.starved_ms += silent_ns as f64 / 1e6,
                Meaning::Hung => {
                    process.attendant.kill();
                    hangs |= incarnation == active;
                }
            }
        }
        if hangs {
            self.noticed(node, "hung", now_ns);
        }
        for (event, at_ns) in events {
            match event {
                Event::Gone { incarnation, .. } => {
                    if incarnation == self.members[node].succession.active() {
                        self.noticed(node, "died", at_ns);
                    }
                    // There is room for the next process beside its dead self.
                    self.guest.remove_dead();
                }
                Event::TookOver(_) => self.noticed(node, "hung", at_ns),
                _ => {}
            }
            self.follow(node, event)?;
        }
        self.follow(node, Event::Tick)?;
        let (cycles, now_us) = (self.members[node].counts.cycles.get(), self.now_ns() as f64 / 1e3);
        for record in self.records.iter_mut().filter(|record| record.node == Some(node)) {
            if record.awaits.is_some_and(|(_, was)| cycles > was) {
                record.recovered_after_us.get_or_insert(now_us - record.t_s * 1e6);
            }
        }
        Ok(())
    }

    /// Notes that the active process of a node is gone or hangs.
    fn noticed(&mut self, node: usize, kind: &str, at_ns: i64) {
        let Member { succession, counts, .. } = &self.members[node];
        let awaits = (succession.active(), counts.cycles.get());
        let waits = matches!(succession.standby(), Standby::Ready { .. });
        let by = if waits { "take-over" } else { "restart" };
        let is_meant = |record: &Record| {
            record.node == Some(node) && record.awaits.is_none_or(|(gone, _)| gone == awaits.0)
        };
        let known = self.records.iter().rposition(is_meant);
        let place = known.unwrap_or(self.records.len());
        if known.is_none() {
            self.record(at_ns, kind, Some(node), self.graph.nodes[node].name.as_str());
        }
        let record = &mut self.records[place];
        let after_us = at_ns as f64 / 1e3 - record.t_s * 1e6;
        let earliest = record.detected_after_us.map_or(after_us, |us| us.min(after_us));
        record.detected_after_us = (after_us > 0.0).then_some(earliest);
        record.awaits.get_or_insert(awaits);
        record.recovered_by.get_or_insert(by);
    }

    fn record(&mut self, at_ns: i64, kind: &str, node: Option<usize>, target: &str) {
        self.records.push(Record {
            t_s: at_ns as f64 / 1e9,
            fault: format!("{kind} {target}"),
            detected_after_us: None,
            recovered_after_us: None,
            recovered_by: None,
            node,
            awaits: None,
        });
    }

    /// Does what follows from an event in the succession of a node's processes.
    fn follow(&mut self, node: usize, event: Event) -> Result<(), Error> {
        let (now_ns, start_ns, mut steps) = (self.now_ns(), self.start_ns, Vec::new());
        self.members[node].succession.on(event, now_ns, &mut steps);
        for step in steps {
            let member = &mut self.members[node];
            let (incarnation, standby_for) = match step {
                Step::Start(incarnation) => {
                    self.spawn(node, incarnation)?;
                    continue;
                }
                Step::Activate(incarnation) => (incarnation, None),
                Step::StandBy { incarnation, active } => {
                    let pid = member.process(active).map_or(0, |process| process.attendant.pid());
                    (incarnation, Some(ActiveProcess { incarnation: active, pid }))
                }
                Step::Replaced { old: gone, .. } | Step::Kill(gone) => {
                    member.process(gone).into_iter().for_each(|process| process.attendant.kill());
                    continue;
                }
                Step::GiveUp | Step::EndRun => {
                    let name = self.graph.nodes[node].name.as_str();
                    self.broken = Some(format!("node {name} ended too often"));
                    continue;
                }
            };
            if let Some(process) = member.process(incarnation) {
                process.silence = Silence::from(now_ns);
                process.attendant.send(&ToService::Start(StartOrder { start_ns, standby_for }));
            }
        }
        Ok(())
    }

    fn apply_faults(&mut self) {
        for (index, fault) in self.graph.faults.iter().enumerate() {
            let (now_ns, (from_ns, to_ns)) = (self.now_ns(), fault.span_ns());
            let due = [now_ns >= from_ns, now_ns >= to_ns];
            let [begins, ends] = [0, 1].map(|at| due[at] && !self.acted[index][at]);
            self.acted[index] = due;
            let node = fault.node().and_then(|name| self.graph.node(name));
            let process = node.and_then(|node| self.members[node].active());
            let (kind, target) = match fault {
                Fault::Kill { node, .. } => ("kill", node),
                Fault::Stop { node, .. } => ("stop", node),
                Fault::Delay { topic, .. } => ("delay", topic),
            };
            match (fault, process) {
                (Fault::Kill { .. }, Some(process)) if begins => process.attendant.kill(),
                (Fault::Stop { .. }, Some(process)) if begins || ends => {
                    process.attendant.stop(begins)
                }
                // The readers know of delays.
                _ => {}
            }
            if begins {
                self.record(self.now_ns(), kind, node, target);
            }
        }
    }

    /// Ends all processes, the standbys first: they must not take over from those that leave.
    pub fn end(&mut self) {
        for member in &mut self.members {
            let active = member.succession.active();
            for process in &mut member.processes {
                match process.incarnation == active {
                    true => process.attendant.send(&ToService::Abort),
                    false => process.attendant.kill(),
                }
            }
        }
        for process in self.members.iter_mut().flat_map(|member| &mut member.processes) {
            let _ = process.attendant.end(GRACE);
        }
    }
}
