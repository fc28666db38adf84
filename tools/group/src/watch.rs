//! A run under way: what happened, what is due, which service is silent. [`super::exits`] has the
//! table of what becomes of a process that ends.

use super::disturbance::Disturbance;
use super::drive::DriveLog;
use super::events::{Answer, Event};
use super::exits::Exit;
use super::faults::Act;
use super::member::{Phase, Verdict};
use super::recording::RecorderProcess;
use super::supervisor::{Ended, Moment, Supervisor};
use crate::Error;
use messages::Service;
use runtime::{FromService, Injected, Mode, StartOrder, ToService, concerned, monotonic_ns};
use scenario::faults::Fault;
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
                if now_ns - looked_ns > STALLED_NS {
                    self.members.iter_mut().for_each(|member| member.reset_silence(now_ns));
                }
                self.check_heartbeats(log, now_ns);
                self.apply_faults(log, now_ns);
                if now_ns < length_ns {
                    self.kill_the_hung(now_ns);
                }
                self.start_the_waiting(&mut course, now_ns);
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
                && (member.phase != Phase::GivenUp || member.service() == Service::Plant)
        });
        if let Some(member) = missing.next() {
            let how = member.exit(LAST_MOMENT, Exit::Unreported).to_string();
            return Ended::Broken { service: member.service(), how };
        }
        let mut given_up = self.members.iter().filter(|member| member.phase == Phase::GivenUp);
        match given_up.next() {
            Some(member) => {
                Ended::GivenUp { service: member.service(), restarts: member.incarnation() }
            }
            None => Ended::Orderly,
        }
    }

    fn now_ns(&self) -> i64 {
        monotonic_ns() - self.start_ns
    }

    fn until_next_look(&self, realtime: bool) -> Duration {
        let awaited = self.members.iter().any(|member| member.phase != Phase::Running)
            || self.faults.is_recovery_awaited();
        match (realtime, awaited) {
            (false, _) => LOCKSTEP_LOOK,
            (true, true) => CLOSE_LOOK,
            (true, false) => {
                let due_ns = self.faults.next_ns().map_or(i64::MAX, |next| next - self.now_ns());
                LOOK.min(Duration::from_nanos(due_ns.max(0).unsigned_abs()))
            }
        }
    }

    fn take(&mut self, event: Event, log: &mut DriveLog, course: &mut Course, now_ns: i64) {
        match event {
            Event::Said(service, FromService::Report(report)) => {
                if course.ended == Ended::Orderly && self.is_early(service, log, course, now_ns) {
                    let member = self.member(service);
                    member.leaves_early(*report);
                    // Its end is an event.
                    member.process().order(&ToService::Abort);
                } else {
                    self.member(service).report = Some(*report);
                }
            }
            Event::Said(_, FromService::Ended(step)) => {
                self.order_all(&ToService::StopAfter(step));
                course.ending();
            }
            Event::Said(service, FromService::Ready(_)) => self.admit(service, now_ns),
            Event::Said(service, FromService::Failed(how)) => {
                self.wrote.push((service, how.clone()));
                if self.launch.mode == Mode::Lockstep {
                    self.break_off(service, how, course);
                }
            }
            Event::Gone(service) if self.member(service).report.is_none() => {
                self.on_exit(service, log, course, now_ns);
            }
            Event::Flooded(service) => self.member(service).kill(Exit::Flooded),
            Event::Signal if course.ended == Ended::Orderly => {
                course.ended = Ended::Interrupted;
                self.order_all(&ToService::Abort);
                course.ending();
            }
            Event::Wrote(service, line) => self.wrote.push((service, line)),
            Event::Inject(fault, reply) => {
                let answer = self.inject(*fault, log, now_ns);
                // The client may be gone.
                let _ = reply.send(answer);
            }
            Event::Gone(_) | Event::Signal | Event::Knock => {}
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

    /// Decides what becomes of a service whose process is gone.
    fn on_exit(&mut self, service: Service, log: &mut DriveLog, course: &mut Course, now_ns: i64) {
        let policy = self.launch.scenario.supervision;
        let member = self.member(service);
        let exit = member.exit_in_run(LAST_MOMENT);
        let awaits = member.incarnation() + 1;
        let kind = if exit == Exit::Flooded { "flooded" } else { "died" };
        self.faults.detected(service, kind, awaits, None, now_ns);
        self.faults.replaced(service);
        self.keep_account(service);
        if self.launch.mode == Mode::Lockstep || course.ended != Ended::Orderly {
            log.remove_dead();
            self.break_off(service, exit.to_string(), course);
            return;
        }
        let verdict = self.member(service).verdict(&policy, exit.is_failure(), now_ns);
        match verdict {
            Verdict::Restart(wait) => {
                let until_ns = now_ns.saturating_add_unsigned(wait.as_nanos() as u64);
                self.member(service).phase = Phase::Waiting { until_ns };
                self.start_the_waiting(course, now_ns);
            }
            Verdict::GiveUp if service != Service::Plant => {
                self.wrote.push((service, format!("{exit}, too often: stopping the vehicle")));
                self.member(service).phase = Phase::GivenUp;
                self.member(Service::Plant).process().order(&ToService::SafeStop);
            }
            Verdict::GiveUp => {
                self.break_off(service, format!("{exit}, too often"), course);
            }
            Verdict::EndRun => self.break_off(service, exit.to_string(), course),
        }
        // While the next process starts: there is room on every topic for it beside its dead self.
        log.remove_dead();
    }

    fn break_off(&mut self, service: Service, how: String, course: &mut Course) {
        if course.ended == Ended::Orderly {
            course.ended = Ended::Broken { service, how };
            self.order_all(&ToService::Abort);
            course.ending();
        }
    }

    fn start_the_waiting(&mut self, course: &mut Course, now_ns: i64) {
        for &service in self.launch.scenario.services() {
            match self.member(service).phase {
                Phase::Waiting { until_ns } if until_ns <= now_ns => {
                    if let Err(error) = self.restart(service, now_ns) {
                        self.break_off(service, error.to_string(), course);
                    }
                }
                Phase::Starting { .. } => {
                    let member = self.member(service);
                    if member.is_overdue(now_ns, RESTART_TIMEOUT_NS) {
                        // Its end is the next event.
                        member.kill(Exit::NotReady);
                    }
                }
                _ => {}
            }
        }
    }

    /// Lets a restarted service into the run.
    fn admit(&mut self, service: Service, now_ns: i64) {
        let start = ToService::Start(StartOrder { start_ns: self.start_ns });
        let injected = self.injected.clone();
        let member = self.member(service);
        member.process().order(&start);
        for fault in injected {
            member.process().order(&ToService::Inject(fault));
        }
        member.begin(now_ns);
        // The others' senders look for it, so that it hears them before their next messages.
        for member in self.members.iter_mut().filter(|m| m.phase == Phase::Running) {
            if member.service() != service {
                member.process().tell_of_peer();
            }
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
            let member = self.member(service);
            if member.phase == Phase::Running
                && member.report.is_none()
                && member.is_hung(now_ns, timeout + period_ns)
            {
                let (awaits, heard_ns) = (member.incarnation() + 1, member.heard_ns());
                member.kill(Exit::Hung);
                member.reset_silence(now_ns);
                self.faults.detected(service, "hung", awaits, Some(heard_ns), now_ns);
            }
        }
    }

    /// Applies the faults of processes that are due.
    fn apply_faults(&mut self, log: &DriveLog, now_ns: i64) {
        let up: BTreeMap<Service, u32> = (self.members.iter())
            .filter(|member| member.phase == Phase::Running && member.report.is_none())
            .map(|member| (member.service(), member.incarnation()))
            .collect();
        let due = self.faults.due(now_ns, log.ego(), |service| up.get(&service).copied());
        for (index, act) in due {
            let mut disturbance = None;
            match act {
                Act::Kill(service) => self.member(service).process().kill(),
                Act::Stop(service) => self.member(service).process().stop(),
                Act::Continue(service) => {
                    self.member(service).process().go_on();
                    continue;
                }
                Act::Hog(core) => disturbance = self.disturb(Disturbance::hog(self.root, core)),
                Act::Memory(mib) => disturbance = self.disturb(Disturbance::memory(self.root, mib)),
            }
            self.faults.done(index, monotonic_ns() - self.start_ns, disturbance);
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
                self.member(service).process().order(&ToService::Inject(injected.clone()));
            }
            self.injected.push(injected);
        }
        Answer { ok: true, message }
    }

    /// A service that is expected to report: one that lives, or is about to again.
    fn silent(&mut self) -> Option<Service> {
        let mut missing = self.members.iter_mut().filter(|member| member.report.is_none());
        missing.find_map(|member| {
            let expected = match member.phase {
                Phase::Waiting { .. } => true,
                Phase::GivenUp => false,
                Phase::Starting { .. } | Phase::Running => member.process().poll().is_none(),
            };
            expected.then(|| member.service())
        })
    }
}
