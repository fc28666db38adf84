//! The cycles of one service: which step is next, when it begins, what was left out.

use crate::counts::statistics::Latencies;
use crate::releases::schedule::Schedule;
use crate::{Clock, Mode, Timetable};
use messages::{Origin, Service, Topic};
use std::rc::Rc;

/// Reaction of a service that missed whole periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overrun {
    /// Runs every missed cycle, late: for the plant, whose integration has no gaps.
    CatchUp,
    /// Leaves them out and counts them: for services that sample the present.
    Skip,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    pub step: u64,
    /// Time of the step, s of run time.
    pub time_s: f64,
    /// Scheduled instant, ns of run time.
    pub scheduled_ns: i64,
    /// Since when the service waited for it, ns of run time: when the one before was done.
    pub idle_ns: i64,
    /// Time when the service really began, ns of run time.
    pub start_ns: i64,
}

#[derive(Debug)]
pub(crate) struct Cycles {
    pub(crate) clock: Rc<Clock>,
    timetable: Timetable,
    service: Service,
    /// The releases of a recorded run, for a replay.
    pub(crate) schedule: Option<Schedule>,
    pub(crate) step: u64,
    pub(crate) next_step: u64,
    /// Cycles run, and releases left out.
    pub(crate) run: u64,
    pub(crate) skipped: u64,
    pub(crate) jitter: Latencies,
}

impl Cycles {
    /// No cycle yet.
    pub(crate) fn new(mode: Mode, timetable: Timetable, service: Service) -> Self {
        Self {
            clock: Rc::new(Clock::new(mode, timetable.step_ns)),
            timetable,
            service,
            schedule: None,
            step: 0,
            next_step: 0,
            run: 0,
            skipped: 0,
            jitter: Latencies::default(),
        }
    }

    /// The sample of `topic` that the present cycle of a recorded run used; `None` without a recorded run.
    pub(crate) fn recorded_input(&self, topic: Topic) -> Option<Origin> {
        self.schedule.as_ref().map(|schedule| schedule.input(topic))
    }

    /// Scheduled instant of the present cycle, ns of run time.
    pub(crate) fn scheduled_ns(&self) -> i64 {
        self.clock.scheduled_ns(self.step)
    }

    /// Time since the scheduled instant of the next release, ns.
    pub(crate) fn late_ns(&self) -> i64 {
        self.clock.now_ns() - self.clock.scheduled_ns(self.next_step)
    }

    pub(crate) fn period_ns(&self) -> i64 {
        self.timetable.period_ns(self.service)
    }

    pub(crate) fn present_step(&self) -> u64 {
        u64::try_from(self.clock.now_ns() / self.timetable.step_ns).unwrap_or(0)
    }

    pub(crate) fn is_of_present_period(&self, step: u64) -> bool {
        step >= self.timetable.latest_release(self.service, self.present_step())
    }

    /// Leaves out the releases that are over by more than a period; true if there were any.
    pub(crate) fn skip_missed(&mut self, late_ns: i64) -> bool {
        let missed = u64::try_from(late_ns / self.period_ns()).unwrap_or(0);
        self.skipped += missed;
        self.next_step += missed * self.timetable.stride(self.service);
        missed > 0
    }

    /// Begins the next cycle of a service that waited since `idle_ns`; `None` after the last recorded one.
    pub(crate) fn begin_next(&mut self, idle_ns: i64) -> Option<Release> {
        let recorded = match &mut self.schedule {
            Some(schedule) => Some(schedule.advance()?),
            None => None,
        };
        self.step = recorded.map_or(self.next_step, |release| release.step);
        // On the service's own grid: a restarted service begins off it.
        self.next_step = self.timetable.latest_release(self.service, self.step)
            + self.timetable.stride(self.service);
        self.clock.set_step(self.step);
        let scheduled_ns = self.scheduled_ns();
        let start_ns = recorded.map_or_else(|| self.clock.now_ns(), |release| release.start_ns);
        if let Some(release) = recorded {
            self.clock.set_simulated(release.publish_ns);
        }
        self.run += 1;
        let idle_ns = match self.clock.mode {
            Mode::Realtime => {
                self.jitter.record_ns(start_ns - scheduled_ns);
                idle_ns
            }
            // The wait begins in an earlier step, and takes no time.
            Mode::Lockstep => start_ns,
        };
        let time_s = scheduled_ns as f64 / 1e9;
        Some(Release { step: self.step, time_s, scheduled_ns, idle_ns, start_ns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of perception-sim: every fifth step of 10 ms.
    fn cycles() -> Cycles {
        let timetable =
            Timetable { step_ns: 10_000_000, strides: [1, 5, 10, 10, 5, 10], last_step: 1000 };
        Cycles::new(Mode::Lockstep, timetable, Service::PerceptionSim)
    }

    #[test]
    fn cycles_follow_the_grid_also_after_a_begin_off_it() {
        let mut cycles = cycles();
        cycles.next_step = 7;
        let steps = [(); 3].map(|()| cycles.begin_next(0).map(|release| release.step));
        assert_eq!(steps, [Some(7), Some(10), Some(15)]);
        assert_eq!((cycles.step, cycles.next_step, cycles.run), (15, 20, 3));
        assert_eq!(cycles.scheduled_ns(), 150_000_000);
        assert!(cycles.is_of_present_period(15) && !cycles.is_of_present_period(14));
    }

    #[test]
    fn releases_that_are_over_by_a_period_are_left_out() {
        let mut cycles = cycles();
        assert!(!cycles.skip_missed(49_999_999) && !cycles.skip_missed(-80_000_000));
        assert!(cycles.skip_missed(149_999_999));
        assert_eq!((cycles.skipped, cycles.next_step, cycles.run), (2, 10, 0));
    }
}
