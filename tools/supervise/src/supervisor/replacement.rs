//! Processes of a run under way that end, and those that replace them.

use super::Supervisor;
use super::roster::Roster;
use super::watch::Course;
use crate::Error;
use crate::events::Who;
use crate::faults::log::FaultLog;
use crate::role::Role;
use crate::succession::{self, Phase, Standby, Step};
use drive::log::DriveLog;
use drive::{Ended, Exit};
use messages::Service;
use runtime::{ActiveProcess, Cause, Mode, Progress, StartOrder, TakeOver, ToService};

/// Time after which a process that was started during the run and is not ready is killed, ns.
const RESTART_TIMEOUT_NS: i64 = 2_000_000_000;

impl Supervisor<'_> {
    /// A process is gone: the succession says what follows.
    pub(super) fn on_exit(
        &mut self,
        who: Who,
        log: &mut DriveLog,
        course: &mut Course,
        now_ns: i64,
    ) {
        let (service, incarnation) = (who.role, who.incarnation);
        let is_active = self.roster.is_active(who);
        let Some((exit, has_told)) = self.roster.of(service).settle(incarnation) else { return };
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
        who: Who,
        told: TakeOver,
        course: &mut Course,
        now_ns: i64,
    ) {
        if course.ended == Ended::Orderly
            && self.roster.is_taken_over(who, told, &mut self.faults.log)
        {
            let took_over = succession::Event::TookOver(who.incarnation);
            self.follow(who.role, took_over, course, now_ns);
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
        let steps = match self.roster.follow(service, event, now_ns) {
            Ok(steps) => steps,
            Err(error) => return self.break_off(service, error.to_string(), course),
        };
        for step in steps {
            if matches!(step, Step::Replaced { .. }) {
                self.faults.replaced(service);
            }
            if !matches!(step, Step::GiveUp | Step::EndRun) {
                continue;
            }
            let how = self.roster.of(service).active().exit_in_run();
            match step {
                Step::EndRun => self.break_off(service, how.to_string(), course),
                _ if service == Service::Plant => {
                    self.break_off(service, format!("{how}, too often"), course);
                }
                _ => {
                    let line = format!("{how}, too often: stopping the vehicle");
                    self.roster.wrote.push((service, line));
                    self.roster.of(Service::Plant).order(&ToService::SafeStop);
                }
            }
        }
    }

    pub(super) fn start_what_is_due(&mut self, course: &mut Course, now_ns: i64) {
        for service in self.launch.scenario.services() {
            self.follow(service, succession::Event::Tick, course, now_ns);
            self.roster.kill_the_late(service, now_ns);
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

impl<R: Role> Roster<'_, R> {
    /// Does what follows from an event in a member's succession. Returns all steps: what a replacement and an end mean
    /// beyond the member is for the caller.
    pub fn follow(
        &mut self,
        role: R,
        event: succession::Event,
        now_ns: i64,
    ) -> Result<Vec<Step>, Error> {
        let steps = self.of(role).on(event, now_ns);
        for step in &steps {
            match *step {
                Step::Start(incarnation) => self.start_next(role, incarnation)?,
                Step::Activate(incarnation) => self.admit(role, incarnation, None, now_ns),
                Step::StandBy { incarnation, active } => {
                    self.admit(role, incarnation, Some(active), now_ns);
                }
                Step::Replaced { old, new } => {
                    // A stopped process cannot end itself.
                    self.kill(Who { role, incarnation: old }, Exit::Replaced);
                    let progress = self.progress(role, new, false);
                    self.of(role).active().begin(now_ns, progress);
                }
                Step::Kill(incarnation) => self.kill(Who { role, incarnation }, Exit::Hung),
                Step::GiveUp | Step::EndRun => {}
            }
        }
        Ok(steps)
    }

    /// Notes in the log that a standby has become the active process; false if it was that already.
    pub fn is_taken_over(&mut self, who: Who<R>, told: TakeOver, log: &mut FaultLog<R>) -> bool {
        let old = self.of(who.role).incarnation();
        let kind = match told.cause {
            Cause::Gone => "died",
            Cause::Silent => "hung",
        };
        if old != who.incarnation {
            log.taken_over(who.role, old, kind, told.noticed_ns - self.start_ns);
        }
        old != who.incarnation
    }

    /// Kills the processes that hang, which `limit_ns` says of each member; their end is an event. The log gets the
    /// active ones.
    pub fn kill_the_hung(
        &mut self,
        now_ns: i64,
        limit_ns: impl Fn(R) -> i64,
        log: &mut FaultLog<R>,
    ) {
        for member in self.iter_mut() {
            let role = member.role;
            for incarnation in member.hung(now_ns, limit_ns(role)) {
                let is_active = member.incarnation() == incarnation;
                let Some(process) = member.attached(incarnation) else { continue };
                process.kill(Exit::Hung);
                if is_active {
                    let heard_ns = Some(process.silence.heard_ns());
                    log.detected(role, "hung", incarnation + 1, heard_ns, now_ns);
                }
            }
        }
    }

    /// Kills a process of a member that should be ready by now; its end is an event.
    pub fn kill_the_late(&mut self, role: R, now_ns: i64) {
        if let Some(incarnation) = self.of(role).overdue(now_ns, RESTART_TIMEOUT_NS) {
            self.kill(Who { role, incarnation }, Exit::NotReady);
        }
    }

    /// Lets in a process that was started during the run. It is a standby of process `stands_by_for`, or the active
    /// one.
    fn admit(&mut self, role: R, incarnation: u32, stands_by_for: Option<u32>, now_ns: i64) {
        self.begin(role, incarnation, stands_by_for, now_ns);
        // The others' senders look for it, so that it receives their next messages.
        for member in self.iter_mut().filter(|m| m.phase() == Phase::Running) {
            let is_own = member.role == role;
            let active = member.incarnation();
            let standby = match member.succession.standby() {
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
        role: R,
        incarnation: u32,
        stands_by_for: Option<u32>,
        now_ns: i64,
    ) {
        let standby_for = stands_by_for.map(|active| {
            let pid = self.of(role).pid_of(active);
            ActiveProcess { incarnation: active, pid }
        });
        let start = ToService::Start(StartOrder { start_ns: self.start_ns, standby_for });
        let progress = self.progress(role, incarnation, stands_by_for.is_some());
        let injected = self.injected.clone();
        let Some(process) = self.of(role).attached(incarnation) else { return };
        process.process.order(&start);
        for fault in injected {
            process.process.order(&ToService::Inject(fault));
        }
        match stands_by_for {
            Some(_) => process.stand_by(now_ns, progress),
            None => process.begin(now_ns, progress),
        }
    }

    /// Signs of life of a process that sends none.
    fn progress(&self, role: R, incarnation: u32, stands_by: bool) -> Option<Progress> {
        let is_seen = stands_by || R::IS_SEEN_BY_COUNTS;
        is_seen.then(|| role.figures(&self.group).progress(incarnation)).flatten()
    }
}
