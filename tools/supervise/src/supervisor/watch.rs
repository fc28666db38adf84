//! A run under way: what happened, what is due, which service is silent. [`super::exits`] has the
//! table of what becomes of a process that ends.

use super::Supervisor;
use crate::Error;
use crate::events::Event;
use crate::member::Member;
use crate::member::attached::LAST_MOMENT;
use crate::recording::Listener;
use crate::succession::{self, Phase};
use drive::log::DriveLog;
use drive::{Ended, Exit, Moment};
use messages::Service;
use runtime::{FromService, Mode, ToService};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Time that services get to report after the run's scheduled end or an order to stop.
const REPORT_GRACE: Duration = Duration::from_secs(3);
/// Longest time between two looks at the run in realtime.
const LOOK: Duration = Duration::from_millis(50);
/// The same while a restarted service is awaited.
const CLOSE_LOOK: Duration = Duration::from_millis(1);
/// The same in lockstep, where senders wait for room in the launcher's own buffer.
const LOCKSTEP_LOOK: Duration = Duration::from_millis(2);
/// The launcher looked so late that the silence may have been its own, ns.
const STALLED_NS: i64 = 100_000_000;

/// Coming end of a run.
pub(super) struct Course {
    pub(super) ended: Ended,
    /// The services were ordered to end before the scenario's end.
    is_stopping: bool,
    /// Time from which a service that has not reported counts as hung.
    deadline: Option<Instant>,
    /// The last time in which the launcher did not look, run time in ns.
    held_up: Option<(i64, i64)>,
}

impl Course {
    /// Earliest start of the state that is found at `now_ns`; `None` if the launcher looked all the time.
    pub(super) fn unseen_since(&self, now_ns: i64) -> Option<i64> {
        let (from_ns, until_ns) = self.held_up?;
        // Events of the meantime are taken one by one.
        (now_ns - until_ns < STALLED_NS).then_some(from_ns)
    }

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
        let table = self.roster.group.timetable;
        let length_ns = table.step_ns * i64::try_from(table.last_step).expect("runs are finite");
        let length = Duration::from_nanos(length_ns.unsigned_abs());
        let end = Instant::now() + length + self.launch.start_delay + REPORT_GRACE;
        let mut course = Course {
            ended: Ended::Orderly,
            is_stopping: false,
            deadline: realtime.then_some(end),
            held_up: None,
        };
        let mut looked_ns = self.roster.now_ns();
        while self.roster.iter().any(|member| member.report.is_none()) {
            let event = self.roster.events.recv_timeout(self.until_next_look(realtime));
            log.drain()?;
            let listeners = self.recording.iter_mut().chain(&mut self.bridge);
            if listeners.map(Listener::has_died).fold(false, |any, died| any | died) {
                log.remove_dead();
            }
            let now_ns = self.roster.now_ns();
            let stalled_ns = now_ns - looked_ns;
            if stalled_ns > STALLED_NS {
                course.held_up = Some((looked_ns, now_ns));
                // Messages of the meantime still wait to be taken.
                let stalled = Duration::from_nanos(stalled_ns.unsigned_abs());
                course.deadline = course.deadline.map(|deadline| deadline + stalled);
            }
            let time_ns = if realtime {
                now_ns.clamp(0, length_ns)
            } else {
                table.step_ns * i64::try_from(log.reached()).expect("runs are finite")
            };
            watch(&Moment { time_ns, drive: log, faults: &self.faults.log.records });
            match event {
                Ok(event) => self.take(event, log, &mut course, now_ns),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(course.ended),
            }
            if realtime && course.ended == Ended::Orderly {
                if stalled_ns > STALLED_NS {
                    self.roster.iter_mut().for_each(|member| member.reset_silence(now_ns));
                }
                for sign in log.take_signs() {
                    self.roster.of(sign.service).sign_of_life(&sign, now_ns);
                }
                for (service, incarnation, published_ns) in log.take_first_messages() {
                    self.faults.log.recovered(service, incarnation, published_ns);
                }
                self.apply_faults(log, now_ns);
                if now_ns < length_ns {
                    self.kill_the_hung(now_ns);
                }
                self.start_what_is_due(&mut course, now_ns);
                self.roster.replace_janitor();
                if (0..length_ns).contains(&now_ns) {
                    self.prepare_one();
                }
            }
            looked_ns = now_ns;
            if self.roster.silent().is_none() {
                break;
            }
            if course.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                if course.ended == Ended::Orderly
                    && let Some(service) = self.roster.silent()
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

    /// End of a run that was not broken off.
    fn how_it_ended(&mut self) -> Ended {
        let is_missing = |member: &&mut Member| {
            member.report.is_none()
                && (member.phase() != Phase::GivenUp || member.role == Service::Plant)
        };
        if let Some(member) = self.roster.iter_mut().find(is_missing) {
            let how = member.active().exit(LAST_MOMENT, Exit::Unreported).to_string();
            return Ended::Broken { service: member.role, how };
        }
        let mut given_up = self.roster.iter().filter(|member| member.phase() == Phase::GivenUp);
        match given_up.next() {
            Some(member) => {
                let restarts = member.succession.replacements();
                Ended::GivenUp { service: member.role, restarts }
            }
            None => Ended::Orderly,
        }
    }

    fn until_next_look(&self, realtime: bool) -> Duration {
        let awaited = self.roster.iter().any(|member| member.phase() != Phase::Running)
            || self.faults.log.is_recovery_awaited();
        match (realtime, awaited) {
            (false, _) => LOCKSTEP_LOOK,
            (true, true) => CLOSE_LOOK,
            (true, false) => {
                let now_ns = self.roster.now_ns();
                let due_ns = self.faults.next_ns(now_ns).map_or(i64::MAX, |next| next - now_ns);
                LOOK.min(Duration::from_nanos(due_ns.unsigned_abs()))
            }
        }
    }

    fn take(&mut self, event: Event, log: &mut DriveLog, course: &mut Course, now_ns: i64) {
        match event {
            // A standby's report says nothing of the run.
            Event::Message(who, FromService::Report(report)) if self.roster.is_active(who) => {
                let service = who.role;
                if course.ended == Ended::Orderly && self.is_early(service, log, course, now_ns) {
                    let member = self.roster.of(service);
                    member.leaves_early(*report);
                    // Its end is an event.
                    member.order(&ToService::Abort);
                } else {
                    self.roster.of(service).report = Some(*report);
                }
            }
            Event::Message(_, FromService::Ended(step)) => {
                self.roster.order_all(&ToService::StopAfter(step));
                course.ending();
            }
            Event::Message(who, FromService::Ready(granted)) => {
                self.roster.granted.insert(who.role.name().into(), granted);
                self.follow(who.role, succession::Event::Ready(who.incarnation), course, now_ns);
            }
            Event::Message(who, FromService::TookOver(take_over)) => {
                self.on_take_over(who, take_over, course, now_ns);
            }
            Event::Message(who, FromService::Failed(how)) => {
                self.roster.wrote.push((who.role, how.clone()));
                if self.launch.mode == Mode::Lockstep && course.ended == Ended::Orderly {
                    match self.roster.culprit(who.role) {
                        Some(culprit) => {
                            self.roster.kill(culprit, Exit::Hung);
                            self.break_off(culprit.role, Exit::Hung.to_string(), course);
                        }
                        None => self.break_off(who.role, how, course),
                    }
                }
            }
            Event::Gone(who) if self.roster.of(who.role).report.is_none() => {
                self.on_exit(who, log, course, now_ns);
            }
            Event::Flooded(who) => self.roster.kill(who, Exit::Flooded),
            Event::Signal if course.ended == Ended::Orderly => {
                course.ended = Ended::Interrupted;
                self.roster.order_all(&ToService::Abort);
                course.ending();
            }
            Event::Output(who, line) => self.roster.wrote.push((who.role, line)),
            Event::Inject(fault, reply) => {
                let answer = self.inject(*fault, log, now_ns);
                // The client may be gone.
                let _ = reply.send(answer);
            }
            Event::Message(_, FromService::Report(_))
            | Event::Gone(_)
            | Event::Signal
            | Event::Knock => {}
        }
    }

    /// True if `service` cannot have come to the run's end yet.
    fn is_early(&self, service: Service, log: &DriveLog, course: &Course, now_ns: i64) -> bool {
        let table = &self.roster.group.timetable;
        let last = table.latest_release(service, table.last_step);
        match self.launch.mode {
            // A run that was ordered to stop ends when it does.
            _ if course.is_stopping => false,
            Mode::Realtime => {
                now_ns < table.step_ns * i64::try_from(last).expect("runs are finite")
            }
            // The odometry that releases the service may still be on its way to this listener. A sender serves one
            // listener after the other.
            Mode::Lockstep => log.reached() + table.stride(Service::Plant) < last,
        }
    }

    pub(super) fn break_off(&mut self, service: Service, how: String, course: &mut Course) {
        if course.ended == Ended::Orderly {
            course.ended = Ended::Broken { service, how };
            self.roster.order_all(&ToService::Abort);
            course.ending();
        }
    }

    /// Kills the services that hang; their end is an event.
    fn kill_the_hung(&mut self, now_ns: i64) {
        let timeout = self.launch.scenario.supervision.heartbeat_timeout_ms.nanoseconds();
        let timeout = i64::try_from(timeout).unwrap_or(i64::MAX);
        let table = self.roster.group.timetable;
        // A heartbeat comes with the service's cycle, and at most ten times a second.
        let limit_ns = |service| timeout + table.period_ns(service).max(100_000_000);
        self.roster.kill_the_hung(now_ns, limit_ns, &mut self.faults.log);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_find_after_the_launcher_was_held_up_may_be_as_old_as_its_last_look() {
        let held_up = Some((1_500_000_000, 2_600_000_000));
        let mut course =
            Course { ended: Ended::Orderly, is_stopping: false, deadline: None, held_up };
        assert_eq!(course.unseen_since(2_600_000_000), Some(1_500_000_000));
        assert_eq!(course.unseen_since(2_650_000_000), Some(1_500_000_000));
        assert_eq!(course.unseen_since(2_800_000_000), None, "all was taken by then");
        course.held_up = None;
        assert_eq!(course.unseen_since(2_600_000_000), None);
    }
}
