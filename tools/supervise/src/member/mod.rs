//! One member of the group over all its processes: their succession, signs of life, accounts.

pub mod attached;
pub mod life;
pub mod silence;

use crate::Error;
use crate::events::{Event as GroupEvent, Who};
use crate::member::attached::Attached;
use crate::member::silence::Share;
use crate::role::Role;
use crate::root::RunRoot;
use crate::start::processes::Process;
use crate::succession::{Event, Phase, Standby, Step, Succession};
use drive::log::Sign;
use drive::report::ServiceReport;
use drive::{Exit, Heartbeats, StandbyCost};
use messages::Service;
use runtime::ToService;
use scenario::supervision::{Restart, Supervision};
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::time::Duration;

/// A service or a node, and its processes.
#[derive(Debug)]
pub struct Member<R = Service> {
    pub role: R,
    program: Option<PathBuf>,
    pub succession: Succession,
    /// All whose exit status was not taken, and the active one, also when it is gone.
    processes: Vec<Attached>,
    /// A process started ahead, which waits to be let in as the next one.
    prepared: Option<Attached>,
    /// One of these was lost: it is alone.
    prepared_failed: bool,
    /// Its report at the run's end.
    pub report: Option<ServiceReport>,
    /// Counts of its earlier processes.
    pub past: Vec<ServiceReport>,
    /// Its signs of life over all its processes.
    pub heartbeats: Heartbeats,
}

impl<R: Role> Member<R> {
    /// Starts the first processes of a member.
    pub fn start(
        role: R,
        program: Option<PathBuf>,
        (policy, restart, with_standby): (&Supervision, Restart, bool),
        root: &RunRoot,
        leader: i32,
        events: &Sender<GroupEvent<R>>,
    ) -> Result<Self, Error> {
        let mut this = Self {
            role,
            program,
            succession: Succession::new(policy, restart, with_standby),
            processes: Vec::new(),
            prepared: None,
            prepared_failed: false,
            report: None,
            past: Vec::new(),
            heartbeats: Heartbeats::default(),
        };
        this.spawn(0, root, leader, events)?;
        if with_standby {
            let group = this.group();
            this.spawn(1, root, group, events)?;
        }
        Ok(this)
    }

    /// Starts process `incarnation`.
    pub fn spawn(
        &mut self,
        incarnation: u32,
        root: &RunRoot,
        leader: i32,
        events: &Sender<GroupEvent<R>>,
    ) -> Result<(), Error> {
        let who = Who { role: self.role, incarnation };
        let ahead = self.prepared.take_if(|one| one.incarnation == incarnation);
        let process = match ahead.map(|one| one.process) {
            Some(mut process) => {
                process.let_in(who, root)?;
                process
            }
            None => {
                Process::spawn(who, self.program.as_ref(), root, leader, events.clone(), false)?
            }
        };
        // The news of a take-over may come before that of the end that it follows.
        let active = self.succession.active();
        self.processes.retain(|one| one.incarnation == active || !one.is_settled);
        self.processes.push(Attached::new(incarnation, process));
        Ok(())
    }

    /// True if a process can be started ahead for it, and there is none. Its standby is faster, and a program of the
    /// user's cannot wait.
    pub fn wants_prepared(&self) -> bool {
        self.program.is_none()
            && self.prepared.is_none()
            && !self.prepared_failed
            && self.succession.standby() == Standby::Unwanted
            && self.succession.replaces()
    }

    /// Starts the next process ahead.
    pub fn prepare(
        &mut self,
        root: &RunRoot,
        leader: i32,
        events: &Sender<GroupEvent<R>>,
    ) -> Result<(), Error> {
        let who = Who { role: self.role, incarnation: self.succession.next() };
        let process = Process::spawn(who, None, root, leader, events.clone(), true);
        self.prepared_failed = process.is_err();
        self.prepared = Some(Attached::new(who.incarnation, process?));
        Ok(())
    }

    /// True if process `incarnation`, which is gone, was only started ahead.
    fn lost_prepared(&mut self, incarnation: u32) -> bool {
        let lost = self.prepared.take_if(|one| one.incarnation == incarnation);
        self.prepared_failed |= lost.is_some();
        lost.map(|mut one| one.process.end(Duration::ZERO)).is_some()
    }

    /// Takes the end of a process during the run: how it ended, and whether it had reported. `None` for one that was
    /// only started ahead, or whose end was taken.
    pub fn settle(&mut self, incarnation: u32) -> Option<(Exit, bool)> {
        if self.lost_prepared(incarnation) {
            return None;
        }
        let process = self.attached(incarnation)?;
        process.is_settled = true;
        Some((process.exit_in_run(), process.has_told))
    }

    pub fn on(&mut self, event: Event, now_ns: i64) -> Vec<Step> {
        let mut steps = Vec::new();
        self.succession.on(event, now_ns, &mut steps);
        steps
    }

    /// Its active process.
    pub fn phase(&self) -> Phase {
        self.succession.phase
    }

    /// All processes that are kept.
    pub fn all(&self) -> Vec<Who<R>> {
        let role = self.role;
        self.processes.iter().map(|one| Who { role, incarnation: one.incarnation }).collect()
    }

    /// Process `incarnation`, unless its exit status was taken long ago.
    pub fn attached(&mut self, incarnation: u32) -> Option<&mut Attached> {
        self.processes.iter_mut().find(|one| one.incarnation == incarnation)
    }

    /// The active process, or the last one there was.
    pub fn active(&mut self) -> &mut Attached {
        let active = self.succession.active();
        self.attached(active).expect("the active process is kept")
    }

    pub fn process(&mut self) -> &mut Process {
        &mut self.active().process
    }

    /// Processes that live or lived lately: the active one, the standby, replaced ones.
    pub fn processes(&mut self) -> impl Iterator<Item = &mut Process> {
        self.processes.iter_mut().map(|one| &mut one.process)
    }

    /// Ends all processes but the active one.
    pub fn dismiss_others(&mut self) {
        let active = self.succession.active();
        let others = self.processes.iter_mut().filter(|one| one.incarnation != active);
        for other in others.chain(&mut self.prepared) {
            other.process.kill();
        }
    }

    /// Sends an order to the active process, and to the standby if it concerns it. An order to end goes to the standby
    /// first: it must not take over from a process that leaves.
    pub fn order(&mut self, order: &ToService) {
        if matches!(order, ToService::Abort) {
            self.dismiss_others();
        }
        for process in self.processes() {
            process.order(order);
        }
    }

    /// Waits until all processes are gone; how the active one ended, which was to leave in `grace`.
    pub fn end(&mut self, grace: Duration) -> Exit {
        self.dismiss_others();
        let exit = self.active().exit(grace, Exit::Unreported);
        for other in self.processes.iter_mut().chain(&mut self.prepared) {
            other.process.end(Duration::ZERO);
        }
        exit
    }

    /// Notes that the active process leaves before the run's end, with this report.
    pub fn leaves_early(&mut self, report: ServiceReport) {
        self.past.push(report);
        self.active().has_told = true;
    }

    /// Notes a heartbeat at `now_ns`.
    pub fn sign_of_life(&mut self, sign: &Sign, now_ns: i64) {
        self.heartbeats.count += 1;
        self.heartbeats.degraded += u64::from(sign.degraded);
        let silent_ms = (now_ns - self.active().silence.heard_ns()) as f64 / 1e6;
        self.heartbeats.longest_silence_ms = self.heartbeats.longest_silence_ms.max(silent_ms);
        if let Some(process) = self.attached(sign.incarnation) {
            process.silence.broken(sign.cycles, now_ns);
        }
    }

    /// Counts the time without a sign of life from `now_ns` on.
    pub fn reset_silence(&mut self, now_ns: i64) {
        self.processes.iter_mut().for_each(|one| one.silence.reset(now_ns));
    }

    /// The active process if it hangs, and the standby if it does.
    pub fn hung(&mut self, now_ns: i64, limit_ns: i64) -> Vec<u32> {
        let mut watched = Vec::new();
        if self.phase() == Phase::Running && self.report.is_none() {
            watched.push(self.succession.active());
            if let Standby::Ready { incarnation } = self.succession.standby() {
                watched.push(incarnation);
            }
        }
        let starved_ms = &mut self.heartbeats.starved_ms;
        let mut hung = Vec::new();
        for one in self.processes.iter_mut().filter(|one| watched.contains(&one.incarnation)) {
            if one.cause.is_none() && one.is_hung(now_ns, limit_ns, starved_ms) {
                hung.push(one.incarnation);
            }
        }
        hung
    }

    /// A process that should be ready by now: it was started before `limit_ns`, and the machine gave it the
    /// processor.
    pub fn overdue(&mut self, now_ns: i64, limit_ns: i64) -> Option<u32> {
        let (incarnation, since_ns) = match (self.phase(), self.succession.standby()) {
            (Phase::Starting { since_ns }, _) => (self.succession.active(), since_ns),
            (_, Standby::Starting { incarnation, since_ns }) => (incarnation, since_ns),
            _ => return None,
        };
        let waited_ns = now_ns - since_ns;
        if waited_ns <= limit_ns {
            return None;
        }
        let pid = self.attached(incarnation)?.process.pid();
        let starved =
            Share::of(pid).is_some_and(|share| Share::default().is_starved(share, waited_ns));
        if starved {
            self.heartbeats.starved_ms += limit_ns as f64 / 1e6;
            self.succession.wait_longer(now_ns);
        }
        (!starved).then_some(incarnation)
    }

    /// Cost of its standby at `now_ns`; `None` without one.
    pub fn standby_cost(&self, now_ns: i64) -> Option<StandbyCost> {
        let Standby::Ready { incarnation } = self.succession.standby() else { return None };
        let standby = self.processes.iter().find(|one| one.incarnation == incarnation)?;
        standby.standby_cost(now_ns)
    }

    /// Index of its active process, from 0.
    pub fn incarnation(&self) -> u32 {
        self.succession.active()
    }

    /// Process id of a process; 0 if it is not known any more.
    pub fn pid_of(&self, incarnation: u32) -> i32 {
        let one = self.processes.iter().find(|one| one.incarnation == incarnation);
        one.map_or(0, |one| one.process.pid())
    }

    /// Process group of its processes.
    pub fn group(&self) -> i32 {
        self.processes.last().map_or(0, |one| one.process.group())
    }

    /// True if any of its processes lives.
    pub fn lives(&mut self) -> bool {
        self.processes().any(|process| process.poll().is_none())
    }
}
