//! The processes of a group: one member for each service or node, the janitor beside them, and how another one starts.

use crate::Error;
use crate::events::{Event, Who};
use crate::member::Member;
use crate::member::silence::Share;
use crate::role::Role;
use crate::root::RunRoot;
use crate::start::processes::Janitor;
use crate::succession::Phase;
use drive::Exit;
use messages::Service;
use runtime::scheduling::Granted;
use runtime::{Group, Injected, ToService, monotonic_ns};
use scenario::supervision::{Restart, Supervision};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender};
use std::time::Duration;

/// Time over which the members are looked at when one waited too long in lockstep.
const CULPRIT_LOOK: Duration = Duration::from_millis(50);

/// The members of a group, what they say, and what a new process of them needs.
#[derive(Debug)]
pub struct Roster<'a, R = Service> {
    pub root: &'a RunRoot,
    pub group: Group,
    pub(crate) janitor: Janitor,
    sender: Sender<Event<R>>,
    /// Messages and ends of the processes.
    pub events: Receiver<Event<R>>,
    members: Vec<Member<R>>,
    /// Run time 0, `CLOCK_MONOTONIC` ns.
    pub start_ns: i64,
    /// Message faults that came during the run, for processes that join later.
    pub(crate) injected: Vec<Injected>,
    /// Scheduling that the kernel granted, by the name of the member.
    pub granted: BTreeMap<String, Granted>,
    /// Lines that processes wrote beside their messages.
    pub wrote: Vec<(R, String)>,
}

impl<'a, R: Role> Roster<'a, R> {
    /// A roster without members; their processes send `events`.
    pub fn new(
        root: &'a RunRoot,
        group: Group,
        (sender, events): (Sender<Event<R>>, Receiver<Event<R>>),
    ) -> Result<Self, Error> {
        Ok(Self {
            root,
            group,
            janitor: Janitor::spawn(root)?,
            sender,
            events,
            members: Vec::new(),
            start_ns: 0,
            injected: Vec::new(),
            granted: BTreeMap::new(),
            wrote: Vec::new(),
        })
    }

    /// Starts the first processes of a member, this program's or those of `program`.
    pub fn start(
        &mut self,
        role: R,
        program: Option<PathBuf>,
        order: (&Supervision, Restart, bool),
    ) -> Result<(), Error> {
        // The first process leads the processes' group.
        let leader = self.leader();
        let member = Member::start(role, program, order, self.root, leader, &self.sender)?;
        if leader == 0 {
            self.janitor.watch(member.group());
        }
        self.members.push(member);
        Ok(())
    }

    pub(super) fn start_next(&mut self, role: R, incarnation: u32) -> Result<(), Error> {
        let leader = self.living_group();
        let (root, events) = (self.root, self.sender.clone());
        let member = self.of(role);
        member.spawn(incarnation, root, leader, &events)?;
        if leader == 0 {
            let group = member.group();
            self.janitor.watch(group);
        }
        Ok(())
    }

    /// Starts a process ahead for one member that has neither a standby nor such a process.
    pub(super) fn prepare_one(&mut self) {
        let leader = self.leader();
        if let Some(member) = self.members.iter_mut().find(|member| member.wants_prepared())
            && let Err(error) = member.prepare(self.root, leader, &self.sender)
        {
            tracing::warn!("cannot start a process ahead: {error}");
        }
    }

    /// Starts another janitor if the present one is gone: without one, a launcher that is killed leaves its run
    /// behind.
    pub fn replace_janitor(&mut self) {
        if self.janitor.0.poll().is_none() {
            return;
        }
        match Janitor::spawn(self.root) {
            Ok(janitor) => {
                self.janitor = janitor;
                let group = self.living_group();
                self.janitor.watch(group);
            }
            Err(error) => tracing::warn!("the janitor is gone and there is no other: {error}"),
        }
    }

    pub fn of(&mut self, role: R) -> &mut Member<R> {
        let member = self.members.iter_mut().find(|member| member.role == role);
        member.expect("all members have been started")
    }

    pub fn iter(&self) -> impl Iterator<Item = &Member<R>> {
        self.members.iter()
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Member<R>> {
        self.members.iter_mut()
    }

    /// Present run time, ns.
    pub fn now_ns(&self) -> i64 {
        monotonic_ns() - self.start_ns
    }

    /// Gives all members an order.
    pub(super) fn order_all(&mut self, order: &ToService) {
        self.members.iter_mut().for_each(|member| member.order(order));
    }

    /// True if a process is the active one of its member.
    pub fn is_active(&mut self, who: Who<R>) -> bool {
        self.of(who.role).incarnation() == who.incarnation
    }

    /// Kills a process; `cause` is how it ended.
    pub(super) fn kill(&mut self, who: Who<R>, cause: Exit) {
        if let Some(process) = self.of(who.role).attached(who.incarnation) {
            process.kill(cause);
        }
    }

    /// The last lines of a member, each on a line of its own.
    pub(super) fn last_lines(&self, role: R) -> String {
        let lines: Vec<_> = self.wrote.iter().filter(|(who, _)| *who == role).collect();
        lines.iter().rev().take(3).rev().map(|(_, line)| format!("\n  {line}")).collect()
    }

    /// A member that is still to report: its process lives, or the next one is about to.
    pub(super) fn silent(&mut self) -> Option<R> {
        let mut missing = self.members.iter_mut().filter(|member| member.report.is_none());
        missing.find_map(|member| {
            let expected = match member.phase() {
                Phase::Waiting { .. } | Phase::Vacant { .. } => true,
                Phase::GivenUp => false,
                Phase::Starting { .. } | Phase::Running => member.process().poll().is_none(),
            };
            expected.then_some(member.role)
        })
    }

    /// The process for which `gave_up` waited in lockstep, directly or not, if the kernel has it.
    pub(super) fn culprit(&mut self, gave_up: R) -> Option<Who<R>> {
        let others = self.members.iter().filter(|member| member.role != gave_up);
        let looked: Vec<(Who<R>, i32, Share)> = others
            .filter_map(|member| {
                let (role, incarnation) = (member.role, member.incarnation());
                let pid = member.pid_of(incarnation);
                Some((Who { role, incarnation }, pid, Share::of(pid)?))
            })
            .collect();
        let before_ns = monotonic_ns();
        std::thread::sleep(CULPRIT_LOOK);
        let elapsed_ns = monotonic_ns() - before_ns;
        let holds_up =
            |pid, before| Share::of(pid).is_some_and(|now| now.holds_up(before, elapsed_ns));
        looked.into_iter().find(|&(_, pid, before)| holds_up(pid, before)).map(|(who, ..)| who)
    }

    /// Process group of the processes; 0 without one.
    pub(super) fn leader(&self) -> i32 {
        self.members.first().map_or(0, Member::group)
    }

    /// Process group of the processes that live; 0 without one.
    fn living_group(&mut self) -> i32 {
        let living = self.members.iter_mut().find_map(|member| {
            (member.phase() != Phase::GivenUp && member.lives()).then(|| member.group())
        });
        living.unwrap_or(0)
    }

    /// Ends all processes; returns how each member's last one ended, which had `grace` to leave.
    pub fn end_all(&mut self, grace: Duration) -> Vec<(R, Exit)> {
        self.order_all(&ToService::Abort);
        self.members.iter_mut().map(|member| (member.role, member.end(grace))).collect()
    }

    /// Drops all but the janitor; the threads that send events end.
    pub fn dissolve(self) -> Janitor {
        self.janitor
    }
}
