//! When a service's cycles begin.

use super::Runtime;
use crate::survival::standby::TakeOver;
use crate::{FromService, Mode, Overrun, Release, RuntimeError, Subscriber, monotonic_ns};
use messages::Message;
use std::sync::atomic::Ordering;
use std::time::Duration;

impl Runtime {
    /// Waits for the next release on the timer; `None` at the end of the run.
    ///
    /// # Errors
    /// [`RuntimeError::Replaced`] if the service's standby has taken over, [`RuntimeError::Send`] if this
    /// process is it and cannot send.
    pub fn next_release(&mut self, overrun: Overrun) -> Result<Option<Release>, RuntimeError> {
        let idle_ns = self.clock.now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                self.finish_take_over()?;
                let scheduled = self.clock.scheduled_ns(self.next_step);
                if self.link.end.is_before(self.next_step) {
                    return Ok(None);
                }
                let late = self.clock.now_ns() - scheduled;
                if late < 0 {
                    match &self.standby {
                        Some(standby) => standby.wait(Duration::from_nanos(late.unsigned_abs())),
                        None => self.clock.sleep_until_run_time(scheduled),
                    }
                } else if overrun == Overrun::CatchUp || !self.skip_missed(late) {
                    break;
                }
            }
        }
        Ok(self.release(idle_ns))
    }

    /// Waits for the next release by a sample of `T`'s topic, which must be due whenever this
    /// service is. In realtime a sample that is `fallback_ns` late is not waited for any longer.
    ///
    /// # Errors
    /// If the topic breaks, and as [`Self::next_release`].
    pub fn next_release_by<T: Message>(
        &mut self,
        samples: &mut Subscriber<T>,
        fallback_ns: i64,
    ) -> Result<Option<Release>, RuntimeError> {
        let idle_ns = self.clock.now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                if self.link.end.is_before(self.next_step) {
                    return Ok(None);
                }
                let ticket = samples.ticket();
                self.finish_take_over()?;
                samples.drain(u64::MAX, |_| {})?;
                let late = self.clock.now_ns() - self.clock.scheduled_ns(self.next_step);
                if self.skip_missed(late) {
                    continue;
                }
                let first = self.is_restarted() && self.cycles == 0;
                if first || samples.reaches(self.next_step) || late >= fallback_ns {
                    break;
                }
                let wait = (fallback_ns - late).clamp(1_000, 50_000_000).unsigned_abs();
                samples.wait(ticket, Duration::from_nanos(wait))?;
            }
        }
        Ok(self.release(idle_ns))
    }

    /// Leaves out the releases that are over by more than a period; true if there were any.
    fn skip_missed(&mut self, late_ns: i64) -> bool {
        let period = self.group.timetable.period_ns(self.service);
        let missed = u64::try_from(late_ns / period).unwrap_or(0);
        self.skipped += missed;
        self.next_step += missed * self.group.timetable.stride(self.service);
        missed > 0
    }

    /// The service's next step on its own grid after `step`: a restarted service begins off it.
    fn step_after(&self, step: u64) -> u64 {
        self.group.timetable.latest_release(self.service, step)
            + self.group.timetable.stride(self.service)
    }

    fn release(&mut self, idle_ns: i64) -> Option<Release> {
        if self.link.end.is_before(self.next_step) {
            return None;
        }
        let recorded = match &mut self.schedule {
            Some(schedule) => Some(schedule.advance()?),
            None => None,
        };
        self.step = recorded.map_or(self.next_step, |release| release.step);
        self.next_step = self.step_after(self.step);
        self.clock.set_step(self.step);
        let scheduled_ns = self.clock.scheduled_ns(self.step);
        let start_ns = recorded.map_or_else(|| self.clock.now_ns(), |release| release.start_ns);
        if let Some(release) = recorded {
            self.clock.set_simulated(release.publish_ns);
        }
        // In lockstep the wait begins in an earlier step, and takes no time.
        let idle_ns = if self.group.mode == Mode::Realtime { idle_ns } else { start_ns };
        if self.group.mode == Mode::Realtime {
            self.jitter.record_ns(start_ns - scheduled_ns);
        }
        self.cycles += 1;
        if let Some(standby) = &mut self.standby {
            standby.look_at_active();
        }
        let time_s = scheduled_ns as f64 / 1e9;
        Some(Release { step: self.step, time_s, scheduled_ns, idle_ns, start_ns })
    }

    /// Connects to processes that joined since the last time, and takes in new faults.
    fn look_around(&self) {
        if self.link.joined.swap(false, Ordering::Relaxed) {
            // A peer that died again at once; the next message tries anew.
            let _ = self.connect();
        }
        self.faults.refresh();
    }

    /// Sends what was computed as a standby, if the service was taken over meanwhile.
    fn finish_take_over(&mut self) -> Result<(), RuntimeError> {
        let Some(standby) = &self.standby else { return Ok(()) };
        if standby.stands_by() {
            return Ok(());
        }
        let Some((cause, noticed_ns)) = standby.taken_over() else {
            return Err(RuntimeError::Replaced);
        };
        self.gate.set_standby(false);
        // What is older than the present period the active process has sent.
        let present = self.group.timetable.latest_release(
            self.service,
            u64::try_from(self.clock.now_ns() / self.group.timetable.step_ns).unwrap_or(0),
        );
        let step = self.step;
        for backlog in self.backlogs.iter().filter(|_| step >= present) {
            backlog.send_held(step)?;
        }
        let sent_ns = monotonic_ns();
        standby.take_priority();
        self.standby = None;
        self.silent = (self.cycles, self.skipped);
        for (_, tally) in self.received.iter() {
            tally.borrow_mut().begin_anew();
        }
        self.figures.set_recording(true);
        self.link.send(FromService::TookOver(TakeOver { cause, noticed_ns, sent_ns }))
    }
}
