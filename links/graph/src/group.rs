//! The nodes as a process group: start, faults, supervision, end. Each node has the car's succession of processes.

use crate::node::{LOOK_NS, request};
use crate::page::Page;
use crate::plan::{Act, Graph};
use crate::times::NodeCounts;
use bench::stage::Stage;
use runtime::scheduling::{Granted, Policy, Priority};
use runtime::{
    ActiveProcess, FromService, Group, Guest, Progress, StartOrder, ToService, monotonic_ns,
};
use scenario::supervision::Supervision;
use serde::{Deserialize, Serialize};
use std::ffi::OsStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use supervise::succession::{Event, Phase, Standby, Step, Succession};
use supervise::{Attendant, Disturbance, Error, Exit, MachineError, Meaning, Share, Silence};

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Run time of its begin, s.
    pub t_s: f64,
    /// `kill`, `stop`, `delay`, `hog`; `died` or `hung` for one that was not asked for.
    pub kind: String,
    pub node: Option<String>,
    pub topic: Option<String>,
    /// Time until the launcher or the standby noticed it, µs.
    pub detected_after_us: Option<f64>,
    /// Time until the first cycle of the next process, µs.
    pub recovered_after_us: Option<f64>,
    /// `restart` or `take-over`.
    pub recovered_by: Option<String>,
    /// The process that is gone or hangs, and cycles of the node when that was noticed.
    #[serde(skip)]
    awaits: Option<(u32, u64)>,
}

/// What happened to the nodes.
pub struct Ran {
    pub granted: Vec<Option<Granted>>,
    pub restarts: Vec<u32>,
    pub take_overs: Vec<u32>,
    /// Time for which a node waited for the processor, ms.
    pub starved_ms: Vec<f64>,
    pub records: Vec<Record>,
    /// Why the run ended early.
    pub broken: Option<String>,
}

struct Process {
    incarnation: u32,
    attendant: Attendant,
    silence: Silence,
    progress: Option<Progress>,
    is_settled: bool,
}

struct Member {
    succession: Succession,
    processes: Vec<Process>,
    counts: NodeCounts,
    granted: Option<Granted>,
    starved_ms: f64,
    /// Longest silence of its loop, ns.
    limit_ns: i64,
}

impl Member {
    fn process(&mut self, incarnation: u32) -> Option<&mut Process> {
        self.processes.iter_mut().find(|process| process.incarnation == incarnation)
    }
}

pub struct Launcher<'a> {
    graph: &'a Graph,
    stage: &'a Stage,
    group: Group,
    guest: Guest,
    members: Vec<Member>,
    leader: i32,
    start_ns: i64,
    records: Vec<Record>,
    broken: Option<String>,
    /// Faults that have begun, and those that act.
    begun: Vec<bool>,
    acting: Vec<(usize, Option<Disturbance>)>,
    _priority: Option<Priority>,
}

impl<'a> Launcher<'a> {
    /// Starts all processes.
    pub fn start(graph: &'a Graph, stage: &'a Stage) -> Result<Self, Error> {
        let group = Group::read(stage.root().path())?;
        graph.write(stage.root().path())?;
        let guest = Guest::join(group.clone(), "graph")?;
        // The page exists before the first node, so that all have the same.
        Page::map(&group)?;
        let policy = Supervision::default();
        let timeout_ns = policy.heartbeat_timeout_ms.nanoseconds().cast_signed();
        let mut members = Vec::new();
        for (index, node) in graph.nodes.iter().enumerate() {
            let load_ns = node.callbacks.iter().map(|callback| callback.load_ns).sum::<i64>();
            let program_ns = if node.program.is_empty() { 0 } else { PROGRAM_NS };
            members.push(Member {
                succession: Succession::new(&policy, policy.restart, node.standby),
                processes: Vec::new(),
                counts: NodeCounts::open(index, None, &group)?,
                granted: None,
                starved_ms: 0.0,
                limit_ns: timeout_ns + LOOK_NS + 2 * load_ns + program_ns,
            });
        }
        let fifo = (0..members.len()).any(|n| matches!(request(graph, n).policy, Policy::Fifo(_)));
        let mut this = Self {
            graph,
            stage,
            group,
            guest,
            members,
            leader: 0,
            start_ns: 0,
            records: Vec::new(),
            broken: None,
            begun: vec![false; graph.faults.len()],
            acting: Vec::new(),
            _priority: None,
        };
        for (node, of) in graph.nodes.iter().enumerate() {
            for incarnation in 0..=u32::from(of.standby) {
                this.spawn(node, incarnation)?;
            }
        }
        // Nodes ask for their own scheduling; an ordinary one would inherit this.
        this._priority = fifo.then(|| Priority::raise(PRIORITY));
        Ok(this)
    }

    /// Process group of the nodes.
    pub fn leader(&self) -> i32 {
        self.leader
    }

    fn spawn(&mut self, node: usize, incarnation: u32) -> Result<(), Error> {
        let words = [node.to_string(), incarnation.to_string()];
        let words = words.each_ref().map(OsStr::new);
        let name = &self.graph.nodes[node].name;
        let root = self.stage.root();
        // A process group ends with its last process.
        let mut all = self.members.iter_mut().flat_map(|member| &mut member.processes);
        if !all.any(|process| !process.attendant.is_gone()) {
            self.leader = 0;
        }
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
        let mut waiting: Vec<(usize, u32)> = Vec::new();
        for (node, member) in self.members.iter().enumerate() {
            waiting.extend(member.processes.iter().map(|process| (node, process.incarnation)));
        }
        while let Some(&(node, incarnation)) = waiting.last() {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let name = &self.graph.nodes[node].name;
            let failed = |how: String| MachineError(format!("node {name} {how}"));
            let process = self.members[node].process(incarnation).expect("just started");
            match process.attendant.receive::<FromService>(Duration::from_millis(20)) {
                Some(FromService::Ready(granted)) => {
                    self.members[node].granted.get_or_insert(granted);
                    waiting.pop();
                }
                Some(FromService::Failed(how)) => {
                    return Err(failed(format!("cannot start: {how}")).into());
                }
                _ if process.attendant.is_gone() => {
                    return Err(failed("ended before the start".into()).into());
                }
                _ if begun.elapsed() > PATIENCE => {
                    return Err(failed("is not ready in time".into()).into());
                }
                _ => {}
            }
        }
        self.start_ns = monotonic_ns() + START_DELAY_NS;
        for node in 0..self.members.len() {
            for incarnation in 0..=u32::from(self.graph.nodes[node].standby) {
                self.follow(node, Event::Ready(incarnation))?;
            }
        }
        Ok(())
    }

    /// Follows the run until its end.
    pub fn run(
        &mut self,
        interrupted: &AtomicBool,
        mut watch: impl FnMut(i64),
    ) -> Result<(), Error> {
        let length_ns = (self.graph.duration_s * 1e9) as i64;
        while self.now_ns() < length_ns && self.broken.is_none() {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            watch(self.now_ns());
            self.apply_faults()?;
            for node in 0..self.members.len() {
                self.look(node)?;
            }
            std::thread::sleep(LOOK);
        }
        watch(length_ns);
        Ok(())
    }

    /// Looks at the processes of a node.
    fn look(&mut self, node: usize) -> Result<(), Error> {
        let now_ns = self.now_ns();
        let (mut events, mut hangs) = (Vec::new(), false);
        let member = &mut self.members[node];
        let (active, standby) = (member.succession.active(), member.succession.standby());
        for process in member.processes.iter_mut().filter(|process| !process.is_settled) {
            let incarnation = process.incarnation;
            while let Some(message) = process.attendant.receive(Duration::ZERO) {
                match message {
                    FromService::Ready(_) => events.push((Event::Ready(incarnation), None)),
                    FromService::TookOver(told) => {
                        events.push((Event::TookOver(incarnation), Some(told.noticed_ns)));
                    }
                    FromService::Failed(how) => {
                        eprintln!("note: {}: {how}", self.graph.nodes[node].name)
                    }
                    _ => {}
                }
            }
            if process.attendant.is_gone() {
                process.is_settled = true;
                let status = process.attendant.end(Duration::ZERO);
                let failed = status.is_none_or(|status| Exit::of(status).is_failure());
                events.push((Event::Gone { incarnation, failed }, None));
                continue;
            }
            let works = incarnation == active && member.succession.phase == Phase::Running
                || standby == Standby::Ready { incarnation };
            if process.progress.is_none() {
                process.progress = NodeCounts::progress(node, incarnation, &self.group);
            }
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
            self.detected(node, "hung", now_ns);
        }
        for (event, noticed_ns) in events {
            self.on(node, event, noticed_ns)?;
        }
        self.follow(node, Event::Tick)?;
        let cycles = self.members[node].counts.cycles.get();
        let now_us = self.now_ns() as f64 / 1e3;
        let name = &self.graph.nodes[node].name;
        for record in self.records.iter_mut().filter(|record| record.node.as_ref() == Some(name)) {
            if record.recovered_after_us.is_none()
                && record.awaits.is_some_and(|(_, was)| cycles > was)
            {
                record.recovered_after_us = Some(now_us - record.t_s * 1e6);
            }
        }
        Ok(())
    }

    fn on(&mut self, node: usize, event: Event, noticed_ns: Option<i64>) -> Result<(), Error> {
        match event {
            Event::Gone { incarnation, .. } => {
                if incarnation == self.members[node].succession.active() {
                    self.detected(node, "died", self.now_ns());
                }
                // There is room for the next process beside its dead self.
                self.guest.remove_dead();
            }
            Event::TookOver(_) => {
                let noticed_ns = noticed_ns.map_or_else(|| self.now_ns(), |ns| ns - self.start_ns);
                self.detected(node, "hung", noticed_ns);
            }
            _ => {}
        }
        self.follow(node, event)
    }

    /// Notes that the active process of a node is gone or hangs.
    fn detected(&mut self, node: usize, kind: &str, now_ns: i64) {
        let name = self.graph.nodes[node].name.clone();
        let Member { succession, counts, .. } = &self.members[node];
        let (gone, cycles) = (succession.active(), counts.cycles.get());
        let by = match succession.standby() {
            Standby::Ready { .. } => "take-over",
            _ => "restart",
        };
        let is_meant = |record: &&mut Record| {
            let of_another = record.awaits.is_some_and(|(process, _)| process != gone);
            record.node.as_ref() == Some(&name) && !of_another
        };
        let now_us = now_ns as f64 / 1e3;
        match self.records.iter_mut().rev().find(is_meant) {
            Some(record) => {
                let after_us = now_us - record.t_s * 1e6;
                let earliest = record.detected_after_us.map_or(after_us, |us| us.min(after_us));
                record.detected_after_us = Some(earliest);
                record.awaits.get_or_insert((gone, cycles));
                record.recovered_by = Some(by.to_owned());
            }
            None => self.records.push(Record {
                detected_after_us: None,
                awaits: Some((gone, cycles)),
                recovered_by: Some(by.to_owned()),
                ..Record::of(now_ns, kind, Some(name), None)
            }),
        }
    }

    /// Does what follows from an event in the succession of a node's processes.
    fn follow(&mut self, node: usize, event: Event) -> Result<(), Error> {
        let mut steps = Vec::new();
        let now_ns = self.now_ns();
        self.members[node].succession.on(event, now_ns, &mut steps);
        for step in steps {
            match step {
                Step::Start(incarnation) => self.spawn(node, incarnation)?,
                Step::Activate(incarnation) => self.admit(node, incarnation, None),
                Step::StandBy { incarnation, active } => {
                    let pid = self.members[node].process(active).map_or(0, |p| p.attendant.pid());
                    let active = ActiveProcess { incarnation: active, pid };
                    self.admit(node, incarnation, Some(active));
                }
                // The standby sees the end itself.
                Step::OrderTakeOver(_) => {}
                Step::Replaced { old: gone, .. } | Step::Kill(gone) => {
                    if let Some(process) = self.members[node].process(gone) {
                        process.attendant.kill();
                    }
                }
                Step::GiveUp | Step::EndRun => {
                    let name = &self.graph.nodes[node].name;
                    self.broken.get_or_insert(format!("node {name} ended too often"));
                }
            }
        }
        Ok(())
    }

    fn admit(&mut self, node: usize, incarnation: u32, standby_for: Option<ActiveProcess>) {
        let (start_ns, now_ns) = (self.start_ns, self.now_ns());
        if let Some(process) = self.members[node].process(incarnation) {
            process.silence = Silence::from(now_ns);
            process.attendant.send(&ToService::Start(StartOrder { start_ns, standby_for }));
        }
    }

    fn apply_faults(&mut self) -> Result<(), Error> {
        let now_ns = self.now_ns();
        let is_over = |index: usize| {
            let fault = &self.graph.faults[index];
            now_ns >= fault.at_ns + fault.for_ns
        };
        let over = self.acting.extract_if(.., |(index, _)| is_over(*index)).collect::<Vec<_>>();
        for (index, _) in over {
            if let Act::Stop(node) = self.graph.faults[index].act {
                self.stop(node, false);
            }
        }
        for (index, fault) in self.graph.faults.iter().enumerate() {
            if self.begun[index] || now_ns < fault.at_ns {
                continue;
            }
            self.begun[index] = true;
            let name = |node: usize| Some(self.graph.nodes[node].name.clone());
            let (kind, node, topic) = match fault.act {
                Act::Kill(node) => ("kill", name(node), None),
                Act::Stop(node) => ("stop", name(node), None),
                Act::Delay(topic, _) => {
                    ("delay", None, Some(self.graph.topics[topic].name.clone()))
                }
                Act::Hog(_) => ("hog", None, None),
            };
            let hog = match fault.act {
                Act::Hog(core) => Some(Disturbance::hog(self.stage.root(), core)?),
                _ => None,
            };
            self.records.push(Record::of(self.now_ns(), kind, node, topic));
            match fault.act {
                Act::Kill(node) => {
                    let active = self.members[node].succession.active();
                    if let Some(process) = self.members[node].process(active) {
                        process.attendant.kill();
                    }
                }
                Act::Stop(node) => self.stop(node, true),
                Act::Delay(..) | Act::Hog(_) => {}
            }
            self.acting.push((index, hog));
        }
        Ok(())
    }

    fn stop(&mut self, node: usize, is_stopped: bool) {
        let active = self.members[node].succession.active();
        if let Some(process) = self.members[node].process(active) {
            process.attendant.stop(is_stopped);
        }
    }

    /// Ends all processes, the standbys first: they must not take over from those that leave.
    pub fn end(mut self) -> (Group, Ran) {
        for member in &mut self.members {
            let active = member.succession.active();
            for process in &mut member.processes {
                if process.incarnation == active {
                    process.attendant.send(&ToService::Abort);
                } else {
                    process.attendant.kill();
                }
            }
        }
        for member in &mut self.members {
            for process in &mut member.processes {
                let _ = process.attendant.end(GRACE);
            }
        }
        let members = &self.members;
        let ran = Ran {
            granted: members.iter().map(|member| member.granted.clone()).collect(),
            restarts: members.iter().map(|m| m.succession.replacements()).collect(),
            take_overs: members.iter().map(|m| m.succession.take_overs()).collect(),
            starved_ms: members.iter().map(|member| member.starved_ms).collect(),
            records: self.records,
            broken: self.broken,
        };
        (self.group, ran)
    }
}

impl Record {
    fn of(now_ns: i64, kind: &str, node: Option<String>, topic: Option<String>) -> Self {
        Self {
            t_s: now_ns as f64 / 1e9,
            kind: kind.to_owned(),
            node,
            topic,
            detected_after_us: None,
            recovered_after_us: None,
            recovered_by: None,
            awaits: None,
        }
    }
}
