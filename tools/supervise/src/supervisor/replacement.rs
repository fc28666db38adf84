//! Processes of a run under way that end, and those that replace them.

use super::Supervisor;
use super::watch::{Course, LAST_MOMENT};
use crate::events::ServiceProcess;
use crate::succession::{self, Phase, Standby, Step};
use drive::log::DriveLog;
use drive::{Ended, Exit};
use messages::Service;
use runtime::{ActiveProcess, Cause, Mode, StartOrder, TakeOver, ToService};

/// Time after which a restarted service that is not ready is killed, ns.
const RESTART_TIMEOUT_NS: i64 = 2_000_000_000;

impl Supervisor<'_> {
    /// A process is gone: the succession says what follows.
    pub(super) fn on_exit(
        &mut self,
        who: ServiceProcess,
        log: &mut DriveLog,
        course: &mut Course,
        now_ns: i64,
    ) {
        let (service, incarnation) = (who.service, who.incarnation);
        if self.roster.of(service).lost_prepared(incarnation) {
            return;
        }
        let is_active = self.roster.is_active(who);
        let Some(process) = self.roster.of(service).attached(incarnation) else { return };
        let exit = process.exit_in_run(LAST_MOMENT);
        let has_told = process.has_told;
        process.is_settled = true;
        self.keep_account(who, has_told);
        if is_active {
            let kind = match exit {
                Exit::Flooded => "flooded",
                Exit::NotReady => "not ready",
                _ => "died",
            };
            // If the launcher was held up itself, the instant in that time is unknown.
            let since_ns = course.unseen_since(now_ns);
            self.faults.log.detected(service, kind, incarnation + 1, since_ns, now_ns);
            self.faults.replaced(service);
        }
        if is_active && (self.launch.mode == Mode::Lockstep || course.ended != Ended::Orderly) {
            log.remove_dead();
            self.break_off(service, exit.to_string(), course);
            return;
        }
        if course.ended == Ended::Orderly {
            let gone = succession::Event::Gone { incarnation, failed: exit.is_failure() };
            self.follow(service, gone, course, now_ns);
            // A replacement that is due at once does not wait for the next look.
            self.follow(service, succession::Event::Tick, course, now_ns);
        }
        // While the next process starts: there is room on every topic for it beside its dead self.
        log.remove_dead();
    }

    /// A standby has become the active process.
    pub(super) fn on_take_over(
        &mut self,
        who: ServiceProcess,
        told: TakeOver,
        course: &mut Course,
        now_ns: i64,
    ) {
        let old = self.roster.of(who.service).incarnation();
        let noticed_ns = told.noticed_ns - self.start_ns;
        let kind = match told.cause {
            Cause::Gone => "died",
            Cause::Silent => "hung",
        };
        if course.ended == Ended::Orderly && old != who.incarnation {
            self.faults.log.taken_over(who.service, old, kind, noticed_ns);
            let took_over = succession::Event::TookOver(who.incarnation);
            self.follow(who.service, took_over, course, now_ns);
        }
    }

    /// Does what follows from an event in a service's succession.
    pub(super) fn follow(
        &mut self,
        service: Service,
        event: succession::Event,
        course: &mut Course,
        now_ns: i64,
    ) {
        for step in self.roster.of(service).on(event, now_ns) {
            match step {
                Step::Start(incarnation) => {
                    if let Err(error) = self.roster.start_next(service, incarnation) {
                        self.break_off(service, error.to_string(), course);
                    }
                }
                Step::Activate(incarnation) => self.admit(service, incarnation, None, now_ns),
                Step::StandBy { incarnation, active } => {
                    self.admit(service, incarnation, Some(active), now_ns);
                }
                Step::Replaced { old, new } => {
                    // A stopped process cannot end itself.
                    self.roster.kill(ServiceProcess { service, incarnation: old }, Exit::Replaced);
                    let member = self.roster.of(service);
                    member.active().begin(now_ns);
                    debug_assert_eq!(member.incarnation(), new);
                    self.faults.replaced(service);
                }
                Step::Kill(incarnation) => {
                    self.roster.kill(ServiceProcess { service, incarnation }, Exit::Hung);
                }
                Step::GiveUp if service != Service::Plant => {
                    let how = self.roster.of(service).active().exit_in_run(LAST_MOMENT);
                    self.journal
                        .wrote
                        .push((service, format!("{how}, too often: stopping the vehicle")));
                    self.roster.of(Service::Plant).order(&ToService::SafeStop);
                }
                Step::GiveUp => {
                    let how = self.roster.of(service).active().exit_in_run(LAST_MOMENT);
                    self.break_off(service, format!("{how}, too often"), course);
                }
                Step::EndRun => {
                    let how = self.roster.of(service).active().exit_in_run(LAST_MOMENT);
                    self.break_off(service, how.to_string(), course);
                }
            }
        }
    }

    pub(super) fn start_what_is_due(&mut self, course: &mut Course, now_ns: i64) {
        for service in self.launch.scenario.services() {
            self.follow(service, succession::Event::Tick, course, now_ns);
            if let Some(incarnation) = self.roster.of(service).overdue(now_ns, RESTART_TIMEOUT_NS) {
                // Its end is the next event.
                self.roster.kill(ServiceProcess { service, incarnation }, Exit::NotReady);
            }
        }
    }

    /// Lets in a process that was started during the run. It is a standby of process `stands_by_for`, or the active
    /// one.
    fn admit(
        &mut self,
        service: Service,
        incarnation: u32,
        stands_by_for: Option<u32>,
        now_ns: i64,
    ) {
        self.begin(service, incarnation, stands_by_for, now_ns);
        // The others' senders look for it, so that it receives their next messages.
        for member in self.roster.iter_mut().filter(|m| m.phase() == Phase::Running) {
            let is_own = member.service() == service;
            let active = member.incarnation();
            let standby = match member.succession().standby() {
                Standby::Ready { incarnation } => Some(incarnation),
                _ => None,
            };
            for peer in [Some(active), standby].into_iter().flatten() {
                if let Some(peer) = member.attached(peer)
                    && !(is_own && peer.incarnation == incarnation)
                {
                    peer.process.tell_of_peer();
                }
            }
        }
    }

    /// Gives a process that is ready the start order, and what was injected before.
    pub(super) fn begin(
        &mut self,
        service: Service,
        incarnation: u32,
        stands_by_for: Option<u32>,
        now_ns: i64,
    ) {
        let standby_for = stands_by_for.map(|active| {
            let pid = self.roster.of(service).pid_of(active);
            ActiveProcess { incarnation: active, pid }
        });
        let start = ToService::Start(StartOrder { start_ns: self.start_ns, standby_for });
        let (injected, group) = (self.faults.injected.clone(), self.group.clone());
        let Some(process) = self.roster.of(service).attached(incarnation) else { return };
        process.process.order(&start);
        for fault in injected {
            process.process.order(&ToService::Inject(fault));
        }
        match stands_by_for {
            Some(_) => process.stand_by(&group, service, now_ns),
            None => process.begin(now_ns),
        }
    }

    /// Starts a process ahead: one at a time, and only while nothing else is to be done.
    pub(super) fn prepare_one(&mut self) {
        let is_quiet = self.roster.iter().all(|member| member.phase() == Phase::Running)
            && !self.faults.log.is_recovery_awaited();
        if is_quiet && self.launch.scenario.supervision.prepared {
            self.roster.prepare_one();
        }
    }
}
