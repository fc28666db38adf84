//! A run under way: what happened, what is due, who is silent.

use super::control::Answer;
use super::disturbance::Disturbance;
use super::drive::DriveLog;
use super::events::Event;
use super::faults::Act;
use super::member::{Phase, Verdict};
use super::recording::RecorderProcess;
use super::supervisor::{EXIT_GRACE, Ended, Moment, Supervisor};
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
/// The same in lockstep, where the launcher's own buffer must not hold anybody up.
const LOCKSTEP_LOOK: Duration = Duration::from_millis(2);
/// A restarted service that is not ready after so long is killed, ns.
const RESTART_TIMEOUT_NS: i64 = 2_000_000_000;
/// The launcher looked so late that the silence may have been its own, ns.
const STALLED_NS: i64 = 100_000_000;

/// How a run is going to end.
struct Course {
    ended: Ended,
    /// When whoever has not reported is taken for hung.
    deadline: Option<Instant>,
}

impl Course {
    fn ending(&mut self) {
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
        let mut course = Course { ended: Ended::Orderly, deadline: realtime.then_some(end) };
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
                Ok(event) => self.take(event, log, &mut course, now_ns)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(course.ended),
            }
            if realtime && course.ended == Ended::Orderly {
                if now_ns - looked_ns > STALLED_NS {
                    self.members.iter_mut().for_each(|member| member.forgive(now_ns));
                }
                self.hear_signs_of_life(log, now_ns);
                self.act_out(log, now_ns);
                if now_ns < length_ns {
                    self.replace_the_hung(now_ns);
                }
                self.start_the_waiting(&mut course, now_ns)?;
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
        // A vehicle that was brought to a stop without a service came to an orderly end.
        let mut missing = self.members.iter_mut().filter(|member| {
            member.report.is_none()
                && (member.phase != Phase::GivenUp || member.service() == Service::Plant)
        });
        if course.ended == Ended::Orderly
            && let Some(member) = missing.next()
        {
            let how = member.how_it_ended(EXIT_GRACE);
            course.ended = Ended::Broken { service: member.service(), how };
        }
        Ok(course.ended)
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

    fn take(
        &mut self,
        event: Event,
        log: &DriveLog,
        course: &mut Course,
        now_ns: i64,
    ) -> Result<(), Error> {
        match event {
            Event::Said(service, FromService::Report(report)) => {
                self.member(service).report = Some(*report);
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
                self.bury(service, log, course, now_ns)?;
            }
            Event::Signal if course.ended == Ended::Orderly => {
                course.ended = Ended::Interrupted;
                self.order_all(&ToService::Abort);
                course.ending();
            }
            Event::Wrote(service, line) => self.wrote.push((service, line)),
            Event::Inject(fault, reply) => {
                let answer = self.inject(*fault, log, now_ns);
                // Who asked may be gone.
                let _ = reply.send(answer);
            }
            Event::Gone(_) | Event::Signal | Event::Knock => {}
        }
        Ok(())
    }

    /// Decides what becomes of a service whose process is gone.
    fn bury(
        &mut self,
        service: Service,
        log: &DriveLog,
        course: &mut Course,
        now_ns: i64,
    ) -> Result<(), Error> {
        let policy = self.launch.scenario.supervision;
        let member = self.member(service);
        let how = member.how_it_ended(EXIT_GRACE);
        let awaits = self.member(service).incarnation() + 1;
        self.faults.detected(service, "died", awaits, now_ns);
        self.faults.replaced(service);
        if self.launch.mode == Mode::Lockstep || course.ended != Ended::Orderly {
            log.remove_dead();
            self.break_off(service, how, course);
            return Ok(());
        }
        let verdict = self.member(service).verdict(&policy, how != "ok", now_ns);
        match verdict {
            Verdict::Restart(wait) => {
                let until_ns = now_ns.saturating_add_unsigned(wait.as_nanos() as u64);
                self.member(service).phase = Phase::Waiting { until_ns };
                self.start_the_waiting(course, now_ns)?;
            }
            Verdict::GiveUp if service != Service::Plant => {
                self.wrote.push((service, format!("{how}, too often: stopping the vehicle")));
                self.member(service).phase = Phase::GivenUp;
                self.member(Service::Plant).process().order(&ToService::SafeStop);
            }
            Verdict::GiveUp | Verdict::EndRun => self.break_off(service, how, course),
        }
        // While the next process starts: there is room on every topic for it beside its dead self.
        log.remove_dead();
        Ok(())
    }

    fn break_off(&mut self, service: Service, how: String, course: &mut Course) {
        if course.ended == Ended::Orderly {
            course.ended = Ended::Broken { service, how };
            self.order_all(&ToService::Abort);
            course.ending();
        }
    }

    fn start_the_waiting(&mut self, course: &mut Course, now_ns: i64) -> Result<(), Error> {
        for &service in self.launch.scenario.services() {
            match self.member(service).phase {
                Phase::Waiting { until_ns } if until_ns <= now_ns => {
                    if let Err(error) = self.restart(service, now_ns) {
                        self.break_off(service, error.to_string(), course);
                    }
                }
                Phase::Starting { since_ns } if now_ns - since_ns > RESTART_TIMEOUT_NS => {
                    // Its end is the next event.
                    self.member(service).process().kill();
                }
                _ => {}
            }
        }
        Ok(())
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

    fn hear_signs_of_life(&mut self, log: &mut DriveLog, now_ns: i64) {
        for sign in log.take_signs() {
            self.member(sign.service).sign_of_life(&sign, now_ns);
        }
        for (service, incarnation, published_ns) in log.take_first_messages() {
            self.faults.recovered(service, incarnation, published_ns);
        }
    }

    /// Kills the services that give no sign of life; their end is an event.
    fn replace_the_hung(&mut self, now_ns: i64) {
        let timeout = self.launch.scenario.supervision.heartbeat_timeout_ms.nanoseconds();
        let timeout = i64::try_from(timeout).unwrap_or(i64::MAX);
        for &service in self.launch.scenario.services() {
            // A heartbeat comes with the service's cycle, and at most ten times a second.
            let period_ns = self.group.timetable.period_ns(service).max(100_000_000);
            let member = self.member(service);
            if member.phase == Phase::Running
                && member.report.is_none()
                && member.silent_ns(now_ns) > timeout + period_ns
            {
                let awaits = member.incarnation() + 1;
                member.process().kill();
                member.forgive(now_ns);
                self.faults.detected(service, "hung", awaits, now_ns);
            }
        }
    }

    /// Does what the faults of processes want done now.
    fn act_out(&mut self, log: &DriveLog, now_ns: i64) {
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
        if let Err(problem) = fault.check("fault") {
            return refused(problem.message);
        }
        if fault.kind.is_of_processes() && lockstep {
            return refused("the run is in lockstep: faults of processes need realtime".into());
        }
        let begin_ns = if lockstep {
            self.group.timetable.step_ns * i64::try_from(log.reached()).expect("runs are finite")
        } else {
            now_ns
        };
        let delay_ns = fault.at_s.map_or(0, |at| at.nanoseconds());
        let begin_ns = begin_ns.saturating_add_unsigned(delay_ns);
        let number = self.faults.plan(fault.clone(), Some(begin_ns));
        let message = format!("{} at {:.3} s", fault.kind.name(), begin_ns as f64 / 1e9);
        if !fault.kind.is_of_processes() {
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
