//! A run under way: what happened, what is due, which service is silent. [`super::exits`] has the
//! table of what becomes of a process that ends.

use super::disturbance::Disturbance;
use super::drive::DriveLog;
use super::events::{Answer, Event, Who};
use super::exits::Exit;
use super::faults::{Act, Living};
use super::processes::Janitor;
use super::recording::RecorderProcess;
use super::succession::{self, Phase, Standby, Step};
use super::supervisor::{Ended, Moment, Supervisor};
use crate::Error;
use messages::Service;
use runtime::{
    ActiveProcess, Cause, FromService, Injected, Mode, StartOrder, TakeOver, ToService, concerned,
    monotonic_ns,
};
use rustix::process::Signal;
use scenario::faults::{Fault, Helper};
use std::collections::BTreeMap;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Time that services get to report after the run's scheduled end or an order to stop.
const REPORT_GRACE: Duration = Duration::from_secs(3);
/// Longest time between two looks at the run in realtime.
const LOOK: Duration = Duration::from_millis(20);
/// The same while a restarted service is awaited.
const CLOSE_LOOK: Duration = Duration::from_millis(1);
/// The same in lockstep, where senders wait for room in the launcher's own buffer.
const LOCKSTEP_LOOK: Duration = Duration::from_millis(2);
/// A restarted service that is not ready after so long is killed, ns.
const RESTART_TIMEOUT_NS: i64 = 2_000_000_000;
/// The launcher looked so late that the silence may have been its own, ns.
const STALLED_NS: i64 = 100_000_000;
/// Time between the end of a process's output and its own.
const LAST_MOMENT: Duration = Duration::from_millis(100);

/// How a run is going to end.
struct Course {
    ended: Ended,
    /// The services were told to end before the scenario's end.
    is_stopping: bool,
    /// When a service that has not reported is taken for hung.
    deadline: Option<Instant>,
}

impl Course {
    fn ending(&mut self) {
        self.is_stopping = true;
        self.deadline = Some(Instant::now() + REPORT_GRACE);
    }
}

impl Supervisor<'_> {
    /// Follows the run until all services reported or the run is broken.
    pub(super) fn follow_run(
        &mut self,
        log: &mut DriveLog,
        watch: &mut dyn FnMut(&Moment<'_>),
    ) -> Result<Ended, Error> {
        let realtime = self.launch.mode == Mode::Realtime;
        let table = self.group.timetable;
        let length_ns = table.step_ns * i64::try_from(table.last_step).expect("runs are finite");
        let length = Duration::from_nanos(length_ns.unsigned_abs());
        let end = Instant::now() + length + self.launch.start_delay + REPORT_GRACE;
        let mut course =
            Course { ended: Ended::Orderly, is_stopping: false, deadline: realtime.then_some(end) };
        let mut looked_ns = self.now_ns();
        while self.members.iter().any(|member| member.report.is_none()) {
            let event = self.events.recv_timeout(self.until_next_look(realtime));
            log.drain()?;
            if self.recording.as_mut().is_some_and(RecorderProcess::has_died) {
                log.remove_dead();
            }
            let now_ns = self.now_ns();
            let stalled_ns = now_ns - looked_ns;
            if stalled_ns > STALLED_NS {
                // What was to be heard meanwhile still waits to be taken.
                let stalled = Duration::from_nanos(stalled_ns.unsigned_abs());
                course.deadline = course.deadline.map(|deadline| deadline + stalled);
            }
            let time_ns = if realtime {
                now_ns.clamp(0, length_ns)
            } else {
                table.step_ns * i64::try_from(log.reached()).expect("runs are finite")
            };
            watch(&Moment { time_ns, drive: log, faults: &self.faults.records });
            match event {
                Ok(event) => self.take(event, log, &mut course, now_ns),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(course.ended),
            }
            if realtime && course.ended == Ended::Orderly {
                if stalled_ns > STALLED_NS {
                    self.members.iter_mut().for_each(|member| member.reset_silence(now_ns));
                }
                self.check_heartbeats(log, now_ns);
                self.apply_faults(log, now_ns);
                if now_ns < length_ns {
                    self.kill_the_hung(now_ns);
                }
                self.start_what_is_due(&mut course, now_ns);
                self.replace_janitor();
                if (0..length_ns).contains(&now_ns) {
                    self.prepare_one();
                }
            }
            looked_ns = now_ns;
            if self.silent().is_none() {
                break;
            }
            if course.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                if course.ended == Ended::Orderly
                    && let Some(service) = self.silent()
                {
                    course.ended = Ended::Broken { service, how: "does not answer".into() };
                }
                break;
            }
        }
        if course.ended == Ended::Orderly {
            course.ended = self.how_it_ended();
        }
        Ok(course.ended)
    }

    /// How a run ended that was not broken off.
    fn how_it_ended(&mut self) -> Ended {
        let mut missing = self.members.iter_mut().filter(|member| {
            member.report.is_none()
                && (member.phase() != Phase::GivenUp || member.service() == Service::Plant)
        });
        if let Some(member) = missing.next() {
            let how = member.active().exit(LAST_MOMENT, Exit::Unreported).to_string();
            return Ended::Broken { service: member.service(), how };
        }
        let mut given_up = self.members.iter().filter(|member| member.phase() == Phase::GivenUp);
        match given_up.next() {
            Some(member) => {
                let restarts = member.succession().replacements();
                Ended::GivenUp { service: member.service(), restarts }
            }
            None => Ended::Orderly,
        }
    }

    fn now_ns(&self) -> i64 {
        monotonic_ns() - self.start_ns
    }

    fn until_next_look(&self, realtime: bool) -> Duration {
        let awaited = self.members.iter().any(|member| member.phase() != Phase::Running)
            || self.faults.is_recovery_awaited();
        match (realtime, awaited) {
            (false, _) => LOCKSTEP_LOOK,
            (true, true) => CLOSE_LOOK,
            (true, false) => {
                let now_ns = self.now_ns();
                let due_ns = self.faults.next_ns(now_ns).map_or(i64::MAX, |next| next - now_ns);
                LOOK.min(Duration::from_nanos(due_ns.unsigned_abs()))
            }
        }
    }

    fn take(&mut self, event: Event, log: &mut DriveLog, course: &mut Course, now_ns: i64) {
        match event {
            // A standby's report says nothing of the run.
            Event::Said(who, FromService::Report(report)) if self.is_active(who) => {
                let service = who.service;
                if course.ended == Ended::Orderly && self.is_early(service, log, course, now_ns) {
                    let member = self.member(service);
                    member.leaves_early(*report);
                    // Its end is an event.
                    member.order(&ToService::Abort);
                } else {
                    self.member(service).report = Some(*report);
                }
            }
            Event::Said(_, FromService::Ended(step)) => {
                self.order_all(&ToService::StopAfter(step));
                course.ending();
            }
            Event::Said(who, FromService::Ready(granted)) => {
                self.granted.insert(who.service.name().into(), granted);
                self.follow(who.service, succession::Event::Ready(who.incarnation), course, now_ns);
            }
            Event::Said(who, FromService::TookOver(take_over)) => {
                self.on_take_over(who, take_over, course, now_ns);
            }
            Event::Said(who, FromService::Failed(how)) => {
                self.wrote.push((who.service, how.clone()));
                if self.launch.mode == Mode::Lockstep {
                    self.break_off(who.service, how, course);
                }
            }
            Event::Gone(who) if self.member(who.service).report.is_none() => {
                self.on_exit(who, log, course, now_ns);
            }
            Event::Flooded(who) => self.kill(who, Exit::Flooded),
            Event::Signal if course.ended == Ended::Orderly => {
                course.ended = Ended::Interrupted;
                self.order_all(&ToService::Abort);
                course.ending();
            }
            Event::Wrote(who, line) => self.wrote.push((who.service, line)),
            Event::Inject(fault, reply) => {
                let answer = self.inject(*fault, log, now_ns);
                // The client may be gone.
                let _ = reply.send(answer);
            }
            Event::Said(_, FromService::Report(_))
            | Event::Gone(_)
            | Event::Signal
            | Event::Knock => {}
        }
    }

    fn is_active(&mut self, who: Who) -> bool {
        self.member(who.service).incarnation() == who.incarnation
    }

    fn kill(&mut self, who: Who, cause: Exit) {
        if let Some(process) = self.member(who.service).attached(who.incarnation) {
            process.kill(cause);
        }
    }

    /// True if `service` cannot have come to the run's end yet.
    fn is_early(&self, service: Service, log: &DriveLog, course: &Course, now_ns: i64) -> bool {
        let table = &self.group.timetable;
        let last = table.latest_release(service, table.last_step);
        match self.launch.mode {
            // A run that was ordered to stop ends when it does.
            _ if course.is_stopping => false,
            Mode::Realtime => {
                now_ns < table.step_ns * i64::try_from(last).expect("runs are finite")
            }
            // The odometry that releases the service may still be on its way to this listener, since a
            // sender serves one listener after the other.
            Mode::Lockstep => log.reached() + table.stride(Service::Plant) < last,
        }
    }

    /// A process is gone: the succession says what follows.
    fn on_exit(&mut self, who: Who, log: &mut DriveLog, course: &mut Course, now_ns: i64) {
        let (service, incarnation) = (who.service, who.incarnation);
        if self.member(service).lost_prepared(incarnation) {
            return;
        }
        let is_active = self.is_active(who);
        let Some(process) = self.member(service).attached(incarnation) else { return };
        let exit = process.exit_in_run(LAST_MOMENT);
        let has_told = process.has_told;
        process.is_settled = true;
        self.keep_account(who, has_told);
        if is_active {
            let kind = if exit == Exit::Flooded { "flooded" } else { "died" };
            self.faults.detected(service, kind, incarnation + 1, None, now_ns);
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
            // What is due at once does not wait for the next look.
            self.follow(service, succession::Event::Tick, course, now_ns);
        }
        // While the next process starts: there is room on every topic for it beside its dead self.
        log.remove_dead();
    }

    /// A standby has become the active process.
    fn on_take_over(&mut self, who: Who, told: TakeOver, course: &mut Course, now_ns: i64) {
        let old = self.member(who.service).incarnation();
        let noticed_ns = told.noticed_ns - self.start_ns;
        let kind = match told.cause {
            Cause::Gone => "died",
            Cause::Silent => "hung",
        };
        if course.ended == Ended::Orderly && old != who.incarnation {
            self.faults.taken_over(who.service, old, kind, noticed_ns);
            let took_over = succession::Event::TookOver(who.incarnation);
            self.follow(who.service, took_over, course, now_ns);
        }
    }

    /// Does what follows from an event in a service's succession.
    fn follow(
        &mut self,
        service: Service,
        event: succession::Event,
        course: &mut Course,
        now_ns: i64,
    ) {
        for step in self.member(service).on(event, now_ns) {
            match step {
                Step::Start(incarnation) => {
                    if let Err(error) = self.start_next(service, incarnation) {
                        self.break_off(service, error.to_string(), course);
                    }
                }
                Step::Activate(incarnation) => self.admit(service, incarnation, None, now_ns),
                Step::StandBy { incarnation, active } => {
                    self.admit(service, incarnation, Some(active), now_ns);
                }
                Step::OrderTakeOver(incarnation) => {
                    if let Some(standby) = self.member(service).attached(incarnation) {
                        standby.process.order(&ToService::TakeOver);
                    }
                }
                Step::Replaced { old, new } => {
                    // It may be stopped, and then could not leave by itself.
                    self.kill(Who { service, incarnation: old }, Exit::Replaced);
                    let member = self.member(service);
                    member.active().begin(now_ns);
                    debug_assert_eq!(member.incarnation(), new);
                    self.faults.replaced(service);
                }
                Step::Kill(incarnation) => {
                    self.kill(Who { service, incarnation }, Exit::Hung);
                }
                Step::GiveUp if service != Service::Plant => {
                    let how = self.member(service).active().exit_in_run(LAST_MOMENT);
                    self.wrote.push((service, format!("{how}, too often: stopping the vehicle")));
                    self.member(Service::Plant).order(&ToService::SafeStop);
                }
                Step::GiveUp => {
                    let how = self.member(service).active().exit_in_run(LAST_MOMENT);
                    self.break_off(service, format!("{how}, too often"), course);
                }
                Step::EndRun => {
                    let how = self.member(service).active().exit_in_run(LAST_MOMENT);
                    self.break_off(service, how.to_string(), course);
                }
            }
        }
    }

    fn break_off(&mut self, service: Service, how: String, course: &mut Course) {
        if course.ended == Ended::Orderly {
            course.ended = Ended::Broken { service, how };
            self.order_all(&ToService::Abort);
            course.ending();
        }
    }

    fn start_what_is_due(&mut self, course: &mut Course, now_ns: i64) {
        for &service in self.launch.scenario.services() {
            self.follow(service, succession::Event::Tick, course, now_ns);
            if let Some(incarnation) = self.member(service).overdue(now_ns, RESTART_TIMEOUT_NS) {
                // Its end is the next event.
                self.kill(Who { service, incarnation }, Exit::NotReady);
            }
        }
    }

    /// Lets a process that was started during the run into it, as a standby of process `stands_by_for`, or as
    /// the active one.
    fn admit(
        &mut self,
        service: Service,
        incarnation: u32,
        stands_by_for: Option<u32>,
        now_ns: i64,
    ) {
        self.begin(service, incarnation, stands_by_for, now_ns);
        // The others' senders look for it, so that it hears them before their next messages.
        for member in self.members.iter_mut().filter(|m| m.phase() == Phase::Running) {
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
            let pid = self.member(service).pid_of(active);
            ActiveProcess { incarnation: active, pid }
        });
        let start = ToService::Start(StartOrder { start_ns: self.start_ns, standby_for });
        let (injected, group) = (self.injected.clone(), self.group.clone());
        let Some(process) = self.member(service).attached(incarnation) else { return };
        process.process.order(&start);
        for fault in injected {
            process.process.order(&ToService::Inject(fault));
        }
        match stands_by_for {
            Some(_) => process.stand_by(&group, service, now_ns),
            None => process.begin(now_ns),
        }
    }

    fn check_heartbeats(&mut self, log: &mut DriveLog, now_ns: i64) {
        for sign in log.take_signs() {
            self.member(sign.service).sign_of_life(&sign, now_ns);
        }
        for (service, incarnation, published_ns) in log.take_first_messages() {
            self.faults.recovered(service, incarnation, published_ns);
        }
    }

    /// Kills the services that hang; their end is an event.
    fn kill_the_hung(&mut self, now_ns: i64) {
        let timeout = self.launch.scenario.supervision.heartbeat_timeout_ms.nanoseconds();
        let timeout = i64::try_from(timeout).unwrap_or(i64::MAX);
        for &service in self.launch.scenario.services() {
            // A heartbeat comes with the service's cycle, and at most ten times a second.
            let period_ns = self.group.timetable.period_ns(service).max(100_000_000);
            for incarnation in self.member(service).hung(now_ns, timeout + period_ns) {
                let who = Who { service, incarnation };
                let heard_ns = self.member(service).attached(incarnation).map(|one| one.heard_ns());
                self.kill(who, Exit::Hung);
                if self.is_active(who) {
                    self.faults.detected(service, "hung", incarnation + 1, heard_ns, now_ns);
                }
            }
        }
    }

    /// Applies the faults of processes that are due.
    fn apply_faults(&mut self, log: &DriveLog, now_ns: i64) {
        let living: BTreeMap<Service, Living> = (self.members.iter())
            .filter(|member| member.report.is_none())
            .filter_map(|member| {
                let starting_since_ns = match member.phase() {
                    Phase::Running => None,
                    Phase::Starting { since_ns } => Some(since_ns),
                    Phase::Vacant { .. } | Phase::Waiting { .. } | Phase::GivenUp => return None,
                };
                let incarnation = member.incarnation();
                Some((member.service(), Living { incarnation, starting_since_ns }))
            })
            .collect();
        let due = self.faults.due(now_ns, log.ego(), |service| living.get(&service).copied());
        for (index, act) in due {
            let mut disturbance = None;
            let mut while_starting = false;
            match act {
                Act::Kill(service) => {
                    while_starting = living[&service].starting_since_ns.is_some();
                    self.member(service).process().kill();
                }
                Act::KillHelper(helper) => self.kill_helper(helper),
                Act::Stop(service) => self.member(service).process().stop(),
                Act::Continue(service) => {
                    self.member(service).process().go_on();
                    continue;
                }
                Act::Hog(core) => disturbance = self.disturb(Disturbance::hog(self.root, core)),
                Act::Memory(mib) => disturbance = self.disturb(Disturbance::memory(self.root, mib)),
            }
            let done_ns = monotonic_ns() - self.start_ns;
            self.faults.done(index, done_ns, disturbance, while_starting);
        }
    }

    fn kill_helper(&mut self, helper: Helper) {
        match helper {
            Helper::Recorder => {
                if let Some(recording) = &mut self.recording {
                    recording.kill();
                }
            }
            Helper::Janitor => self.janitor.kill(),
            // It is this process.
            Helper::Launcher => {
                let _ = rustix::process::kill_process(rustix::process::getpid(), Signal::KILL);
            }
        }
    }

    /// Starts another janitor in the place of one that is gone: without one a launcher that is killed leaves its
    /// run behind.
    fn replace_janitor(&mut self) {
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

    /// Starts a process ahead for a service that has neither a standby nor such a process: one at a time, and
    /// only while nothing else is to be done.
    fn prepare_one(&mut self) {
        let is_quiet = self.members.iter().all(|member| member.phase() == Phase::Running)
            && !self.faults.is_recovery_awaited();
        if !is_quiet || !self.launch.scenario.supervision.prepared {
            return;
        }
        let (root, leader, sender) = (self.root, self.leader(), self.sender.clone());
        if let Some(member) = self.members.iter_mut().find(|member| member.wants_prepared())
            && let Err(error) = member.prepare(root, leader, &sender)
        {
            tracing::warn!("no process is started ahead: {error}");
        }
    }

    fn disturb(&self, started: Result<Disturbance, Error>) -> Option<Disturbance> {
        started.inspect_err(|error| tracing::warn!("{error}")).ok()
    }

    /// Takes a fault from outside.
    fn inject(&mut self, fault: Fault, log: &DriveLog, now_ns: i64) -> Answer {
        let lockstep = self.launch.mode == Mode::Lockstep;
        let refused = |message: String| Answer { ok: false, message };
        let is_of_processes = fault.effect.of_processes().is_some();
        if is_of_processes && lockstep {
            return refused("the run is in lockstep: faults of processes need realtime".into());
        }
        let begin_ns = if lockstep {
            self.group.timetable.step_ns * i64::try_from(log.reached()).expect("runs are finite")
        } else {
            now_ns
        };
        let begin_ns = begin_ns.saturating_add(fault.begin.known_ns().unwrap_or(0));
        let number = self.faults.plan(fault.clone(), Some(begin_ns));
        let message = format!("{} at {:.3} s", fault.effect.kind(), begin_ns as f64 / 1e9);
        if !is_of_processes {
            let concerned = concerned(&fault);
            let injected = Injected { number, begin_ns, fault };
            for service in concerned {
                self.member(service).order(&ToService::Inject(injected.clone()));
            }
            self.injected.push(injected);
        }
        Answer { ok: true, message }
    }

    /// A service that is expected to report: one that lives, or is about to again.
    fn silent(&mut self) -> Option<Service> {
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
}
