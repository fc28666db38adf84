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
    /// [`RuntimeError::Replaced`] if the service's standby has taken over, [`RuntimeError::Topic`] if this
    /// process is it and cannot send.
    pub fn next_release(&mut self, overrun: Overrun) -> Result<Option<Release>, RuntimeError> {
        let idle_ns = self.clock().now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                self.finish_take_over()?;
                if self.is_over() {
                    return Ok(None);
                }
                let late = self.cycles.late_ns();
                if late < 0 {
                    match &self.survival.standby {
                        Some(standby) => standby.wait(Duration::from_nanos(late.unsigned_abs())),
                        None => self.cycles.clock.sleep_until(self.cycles.next_step),
                    }
                } else if overrun == Overrun::CatchUp || !self.cycles.skip_missed(late) {
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
        let idle_ns = self.clock().now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                if self.is_over() {
                    return Ok(None);
                }
                let ticket = samples.ticket();
                self.finish_take_over()?;
                samples.drain(|_| {})?;
                let late = self.cycles.late_ns();
                if self.cycles.skip_missed(late) {
                    continue;
                }
                let first = self.is_restarted() && self.cycles.run == 0;
                if first || samples.reaches(self.cycles.next_step) || late >= fallback_ns {
                    break;
                }
                // A signal, a take-over and each sample end the wait.
                let wait = (fallback_ns - late).max(1_000).unsigned_abs();
                samples.wait(ticket, Duration::from_nanos(wait))?;
            }
        }
        Ok(self.release(idle_ns))
    }

    /// True if the next step is not to be run any more.
    fn is_over(&self) -> bool {
        self.life.link.orders.end.is_before(self.cycles.next_step)
    }

    fn release(&mut self, idle_ns: i64) -> Option<Release> {
        if self.is_over() {
            return None;
        }
        let release = self.cycles.begin_next(idle_ns)?;
        if let Some(standby) = &mut self.survival.standby {
            standby.look_at_active();
        }
        Some(release)
    }

    /// Connects to processes that joined since the last time, and takes in new faults.
    fn look_around(&self) {
        if self.life.link.orders.joined.swap(false, Ordering::Relaxed) {
            // A peer that died again at once is not an error: the next message tries anew.
            let _ = self.ports.connect();
        }
        self.injection.faults.refresh();
    }

    /// Sends what was computed as a standby, if the service was taken over meanwhile.
    fn finish_take_over(&mut self) -> Result<(), RuntimeError> {
        let Some(standby) = &self.survival.standby else { return Ok(()) };
        if standby.stands_by() {
            return Ok(());
        }
        let Some((cause, noticed_ns)) = standby.taken_over() else {
            return Err(RuntimeError::Replaced);
        };
        self.survival.gate.set_standby(false);
        // The active process has sent what is older than the present period.
        let step = self.cycles.step;
        if self.cycles.is_of_present_period(step) {
            self.ports.send_held(step)?;
        }
        let sent_ns = monotonic_ns();
        standby.take_priority();
        self.survival.become_active(self.cycles.run, self.cycles.skipped);
        self.ports.count_received_anew();
        self.life.link.send(FromService::TookOver(TakeOver { cause, noticed_ns, sent_ns }))
    }
}
