//! The processes of a group: one member for each service, the janitor beside them, and how another one starts.

use crate::Error;
use crate::events::{Event, ServiceProcess};
use crate::member::Member;
use crate::member::silence::Share;
use crate::root::RunRoot;
use crate::start::processes::{Janitor, Launch};
use crate::succession::Phase;
use drive::Exit;
use messages::Service;
use runtime::{ToService, monotonic_ns};
use std::collections::BTreeMap;
use std::sync::mpsc::Sender;
use std::time::Duration;

/// Time over which the services are looked at when one waited too long in lockstep.
const CULPRIT_LOOK: Duration = Duration::from_millis(50);

/// The members of a group, and what a new process of them needs.
pub(super) struct Roster<'a> {
    pub(super) root: &'a RunRoot,
    pub(super) janitor: Janitor,
    events: Sender<Event>,
    members: Vec<Member>,
}

impl<'a> Roster<'a> {
    /// A roster without members; their processes send `events`.
    pub(super) fn new(root: &'a RunRoot, janitor: Janitor, events: Sender<Event>) -> Self {
        Self { root, janitor, events, members: Vec::new() }
    }

    /// Starts the first processes of each service.
    pub(super) fn start_all(&mut self, launch: &Launch) -> Result<(), Error> {
        let policy = &launch.scenario.supervision;
        for service in launch.scenario.services() {
            // The first process leads the services' process group.
            let leader = self.leader();
            let program = launch.programs.get(&service).cloned();
            let who = (service, policy.standby.contains(&service));
            let member = Member::start(who, program, policy, self.root, leader, &self.events)?;
            if leader == 0 {
                self.janitor.watch(member.group());
            }
            self.members.push(member);
        }
        Ok(())
    }

    pub(super) fn start_next(&mut self, service: Service, incarnation: u32) -> Result<(), Error> {
        let leader = self.living_group();
        let (root, events) = (self.root, self.events.clone());
        let member = self.of(service);
        member.spawn(incarnation, root, leader, &events)?;
        if leader == 0 {
            let group = member.group();
            self.janitor.watch(group);
        }
        Ok(())
    }

    /// Starts a process ahead for one service that has neither a standby nor such a process.
    pub(super) fn prepare_one(&mut self) {
        let leader = self.leader();
        if let Some(member) = self.members.iter_mut().find(|member| member.wants_prepared())
            && let Err(error) = member.prepare(self.root, leader, &self.events)
        {
            tracing::warn!("cannot start a process ahead: {error}");
        }
    }

    /// Starts another janitor if the present one is gone: without one, a launcher that is killed leaves its run
    /// behind.
    pub(super) fn replace_janitor(&mut self) {
        if !self.janitor.is_gone() {
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

    pub(super) fn of(&mut self, service: Service) -> &mut Member {
        let member = self.members.iter_mut().find(|member| member.service() == service);
        member.expect("all services have been started")
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Member> {
        self.members.iter()
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Member> {
        self.members.iter_mut()
    }

    /// Gives all members an order.
    pub(super) fn order_all(&mut self, order: &ToService) {
        self.members.iter_mut().for_each(|member| member.order(order));
    }

    /// True if a process is the active one of its service.
    pub(super) fn is_active(&mut self, who: ServiceProcess) -> bool {
        self.of(who.service).incarnation() == who.incarnation
    }

    /// Kills a process; `cause` is how it ended.
    pub(super) fn kill(&mut self, who: ServiceProcess, cause: Exit) {
        if let Some(process) = self.of(who.service).attached(who.incarnation) {
            process.kill(cause);
        }
    }

    /// A service that is still to report: its process lives, or the next one is about to.
    pub(super) fn silent(&mut self) -> Option<Service> {
        let mut missing = self.members.iter_mut().filter(|member| member.report.is_none());
        missing.find_map(|member| {
            let expected = match member.phase() {
                Phase::Waiting { .. } | Phase::Vacant { .. } => true,
                Phase::GivenUp => false,
                Phase::Starting { .. } | Phase::Running => member.process().poll().is_none(),
            };
            expected.then(|| member.service())
        })
    }

    /// The process for which `gave_up` waited in lockstep, directly or not, if the kernel has it.
    pub(super) fn culprit(&mut self, gave_up: Service) -> Option<ServiceProcess> {
        let others = self.members.iter().filter(|member| member.service() != gave_up);
        let looked: Vec<(ServiceProcess, i32, Share)> = others
            .filter_map(|member| {
                let (service, incarnation) = (member.service(), member.incarnation());
                let pid = member.pid_of(incarnation);
                Some((ServiceProcess { service, incarnation }, pid, Share::of(pid)?))
            })
            .collect();
        let before_ns = monotonic_ns();
        std::thread::sleep(CULPRIT_LOOK);
        let elapsed_ns = monotonic_ns() - before_ns;
        let holds_up =
            |pid, before| Share::of(pid).is_some_and(|now| now.holds_up(before, elapsed_ns));
        looked.into_iter().find(|&(_, pid, before)| holds_up(pid, before)).map(|(who, ..)| who)
    }

    /// Process group of the services; 0 without one.
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

    /// Ends all processes; returns how each service's last one ended, which had `grace` to leave.
    pub(super) fn end_all(&mut self, grace: Duration) -> BTreeMap<Service, Exit> {
        self.order_all(&ToService::Abort);
        self.members.iter_mut().map(|member| (member.service(), member.end(grace))).collect()
    }

    /// Drops all but the janitor; the threads that send events end.
    pub(super) fn dissolve(self) -> Janitor {
        self.janitor
    }
}
