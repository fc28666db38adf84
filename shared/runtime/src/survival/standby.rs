//! The second process of a service: attached, computing, silent, until it takes the service over.
//!
//! ```text
//! thread `standby`: end of the active process ──┬─► Order::take_over ─► epoch ─► loop sends what it holds
//! the loop:         no cycle for too long ──────┘   (the first one counts)
//! ```
//!
//! The end of the active process is known by [`end_word`], or by its pidfd.

use crate::counts::figures::{Figures, Progress};
use crate::machine::scheduling::{Granted, Request, above, below_services, set_fifo_of};
use crate::survival::end_word;
use crate::survival::fence;
use crate::transport::waking::wake_word;
use crate::words::{RunWords, Shared};
use crate::{Group, RuntimeError, monotonic_ns};
use messages::{Service, Topic};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use rustix::thread::{futex, gettid};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveProcess {
    pub incarnation: u32,
    pub pid: i32,
}

/// Reason of a take-over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The active process ended.
    Gone,
    /// The active process completed no cycle for too long.
    Silent,
}

/// A take-over, as the standby reports it to the launcher.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TakeOver {
    pub cause: Cause,
    /// Time when the standby noticed it, `CLOCK_MONOTONIC` ns.
    pub noticed_ns: i64,
    /// Time when it had sent what it had computed, `CLOCK_MONOTONIC` ns.
    pub sent_ns: i64,
}

/// States of [`Order::state`].
const STANDING_BY: u32 = 0;
const TOOK_OVER: u32 = 1;
const REPLACED: u32 = 2;

/// Data that the threads of a standby share.
#[derive(Debug)]
struct Order {
    words: Arc<Shared<RunWords>>,
    service: Service,
    active: u32,
    own: u32,
    /// A futex that the loop waits for.
    state: AtomicU32,
    /// Reason why the first of the threads acted, and when it noticed.
    noticed: OnceLock<(Cause, i64)>,
    /// The loop's thread, and its priority as the active process; 0 without a real-time priority.
    thread: i32,
    priority: u8,
}

impl Order {
    fn take_over(&self, cause: Cause, noticed_ns: i64) {
        if self.noticed.set((cause, noticed_ns)).is_err() {
            return;
        }
        let word = &self.words.of(self.service).epoch;
        let took = fence::take_over(word, self.active, self.own);
        if took {
            // Above the old process's loop, which gives its memory back at its priority on the same core.
            set_fifo_of(self.thread, above(self.priority));
        }
        self.state.store(if took { TOOK_OVER } else { REPLACED }, Ordering::Release);
        // An address of this process's own: waking cannot fail.
        let _ = futex::wake(&self.state, futex::Flags::PRIVATE, i32::MAX.unsigned_abs());
    }
}

/// The loop's side of a standby.
#[derive(Debug)]
pub(crate) struct Standby {
    order: Arc<Order>,
    /// The active process's progress; `None` if the process is gone or keeps no account.
    progress: Option<Progress>,
    watch: CycleWatch,
}

impl Standby {
    pub(crate) fn begin(
        group: &Group,
        words: &Arc<Shared<RunWords>>,
        scenario: &Scenario,
        (service, own): (Service, u32),
        active: ActiveProcess,
        granted: &Granted,
    ) -> Result<Self, RuntimeError> {
        let request = Request::of(scenario, service);
        let priority = granted.priority(&request);
        let order = Arc::new(Order {
            words: Arc::clone(words),
            service,
            active: active.incarnation,
            own,
            state: AtomicU32::new(STANDING_BY),
            noticed: OnceLock::new(),
            thread: gettid().as_raw_pid(),
            priority,
        });
        if priority > 0 {
            // A standby must not delay the active process.
            set_fifo_of(0, below_services(scenario));
        }
        let watched = Arc::clone(&order);
        let pidfd =
            Pid::from_raw(active.pid).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        let watch = move || watch(&watched, pidfd, priority);
        std::thread::Builder::new()
            .name("standby".into())
            .stack_size(64 * 1024)
            .spawn(watch)
            .map_err(RuntimeError::setup("a standby's thread"))?;
        let timeout_ns = scenario.supervision.standby_timeout_ms.nanoseconds();
        let timeout_ns = i64::try_from(timeout_ns).unwrap_or(i64::MAX);
        let period_ns = group.timetable.period_ns(service);
        let progress = Figures::of(group, service).progress(active.incarnation);
        Ok(Self { order, progress, watch: CycleWatch::new(monotonic_ns(), period_ns, timeout_ns) })
    }

    /// True while nothing has happened to the active process.
    pub(crate) fn stands_by(&self) -> bool {
        self.order.state.load(Ordering::Acquire) == STANDING_BY
    }

    /// Reason why it took over and when it noticed; `None` if another process has the service.
    pub(crate) fn taken_over(&self) -> Option<(Cause, i64)> {
        let took = self.order.state.load(Ordering::Acquire) == TOOK_OVER;
        self.order.noticed.get().copied().filter(|_| took)
    }

    /// Gives the loop the active process's priority, once it has sent what could not wait.
    pub(crate) fn take_priority(&self) {
        set_fifo_of(self.order.thread, self.order.priority);
    }

    /// Waits for the take-over, at most for `timeout`; a signal ends the wait early.
    pub(crate) fn wait(&self, timeout: Duration) {
        if let Ok(timeout) = timeout.try_into() {
            // The caller looks at the time and at the state after every wait.
            let (word, private) = (&self.order.state, futex::Flags::PRIVATE);
            let _ = futex::wait(word, private, STANDING_BY, Some(&timeout));
        }
    }

    /// Looks, once in a cycle, whether the active process makes progress, and takes over if it does not.
    pub(crate) fn look_at_active(&mut self) {
        let Some(progress) = &self.progress else { return };
        let now_ns = monotonic_ns();
        if self.watch.is_silent(now_ns, progress.cycles()) {
            self.order.take_over(Cause::Silent, now_ns);
        }
    }
}

/// Decides by another process's count of cycles whether that process works.
#[derive(Debug)]
pub struct CycleWatch {
    /// Cycles that it had done at the last look, and since when it had done them.
    cycles: u64,
    since_ns: i64,
    looked_ns: i64,
    period_ns: i64,
    timeout_ns: i64,
}

impl CycleWatch {
    /// A watch from `now_ns` on over a process that works every `period_ns`.
    pub fn new(now_ns: i64, period_ns: i64, timeout_ns: i64) -> Self {
        Self { cycles: 0, since_ns: now_ns, looked_ns: now_ns, period_ns, timeout_ns }
    }

    /// Looks at the count at `now_ns`; true if the process completed no cycle for a period and the timeout.
    pub fn is_silent(&mut self, now_ns: i64, cycles: u64) -> bool {
        // If this process did not get the processor, the other one may not have got it either.
        let stalled = 2 * (now_ns - self.looked_ns) > 3 * self.period_ns.max(self.timeout_ns);
        self.looked_ns = now_ns;
        if cycles != self.cycles || stalled {
            (self.cycles, self.since_ns) = (cycles, now_ns);
            return false;
        }
        now_ns - self.since_ns > self.period_ns + self.timeout_ns
    }
}

/// Waits for the end of the active process. One that has no pidfd was gone before.
fn watch(order: &Order, pidfd: Option<OwnedFd>, priority: u8) {
    // Above the loop that it raises.
    set_fifo_of(gettid().as_raw_pid(), above(priority));
    if let Some(pidfd) = pidfd
        && !end_word::wait(&order.words, order.service, order.active)
    {
        let mut ends = [PollFd::new(&pidfd, PollFlags::IN)];
        while !matches!(poll(&mut ends, None), Ok(1..)) {}
    }
    order.take_over(Cause::Gone, monotonic_ns());
    // The loop waits for a topic which can release it.
    for topic in [Topic::RadarTracks, Topic::RadarDetections] {
        wake_word(order.words.wake(topic));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survival::fence::tests::Run;
    use proptest::prelude::*;

    /// A standby of the controller, process 1, for process 0, without the threads.
    fn order(run: &Run) -> Arc<Order> {
        Arc::new(Order {
            words: run.peers().words,
            service: Service::Controller,
            active: 0,
            own: 1,
            state: AtomicU32::new(STANDING_BY),
            noticed: OnceLock::new(),
            thread: 0,
            priority: 0,
        })
    }

    fn standby(order: &Arc<Order>) -> Standby {
        let watch = CycleWatch::new(0, 100, 30);
        Standby { order: Arc::clone(order), progress: None, watch }
    }

    fn run(name: &str) -> Run {
        Run::new(name, &[Service::Controller])
    }

    #[test]
    fn the_first_cause_takes_over_once() {
        let run = run("first-cause");
        let order = order(&run);
        let standby = standby(&order);
        assert!(standby.stands_by());
        assert_eq!(standby.taken_over(), None);
        order.take_over(Cause::Silent, 17);
        order.take_over(Cause::Gone, 18);
        assert!(!standby.stands_by());
        assert_eq!(standby.taken_over(), Some((Cause::Silent, 17)));
        assert_eq!(order.words.of(Service::Controller).epoch.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn a_standby_whose_service_another_process_took_is_replaced() {
        let run = run("replaced-standby");
        let order = order(&run);
        order.words.of(Service::Controller).epoch.store(2, Ordering::SeqCst);
        order.take_over(Cause::Gone, 17);
        let standby = standby(&order);
        assert!(!standby.stands_by());
        assert_eq!(standby.taken_over(), None);
        assert_eq!(order.words.of(Service::Controller).epoch.load(Ordering::SeqCst), 2);
    }

    const PERIOD_NS: i64 = 100;
    const TIMEOUT_NS: i64 = 30;

    #[test]
    fn a_process_is_silent_after_a_period_and_the_timeout() {
        let mut watch = CycleWatch::new(1_000, PERIOD_NS, TIMEOUT_NS);
        assert!(!watch.is_silent(1_100, 1), "its first cycle");
        assert!(!watch.is_silent(1_200, 1));
        assert!(!watch.is_silent(1_230, 1), "not longer than both");
        assert!(watch.is_silent(1_231, 1));
        assert!(watch.is_silent(1_300, 1), "it stays silent");
        assert!(!watch.is_silent(1_310, 2), "it works again");
        assert!(!watch.is_silent(1_440, 2));
        assert!(watch.is_silent(1_441, 2));
    }

    #[test]
    fn an_observer_that_did_not_run_itself_starts_anew() {
        let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
        assert!(watch.is_silent(150, 0), "1.5 periods between two looks are usual");
        let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
        assert!(!watch.is_silent(151, 0), "more are not");
        assert!(!watch.is_silent(281, 0), "from 151 on");
        assert!(watch.is_silent(282, 0));
        // The longer one of period and timeout is the measure.
        let mut watch = CycleWatch::new(0, PERIOD_NS, 1_000);
        assert!(watch.is_silent(1_500, 0), "1.5 timeouts");
        let mut watch = CycleWatch::new(0, PERIOD_NS, 1_000);
        assert!(!watch.is_silent(1_501, 0));
    }

    proptest! {
        #[test]
        fn a_process_that_completes_a_cycle_before_each_look_is_never_silent(
            pauses in prop::collection::vec(1_i64..2_000, 1..50),
        ) {
            let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
            let mut now_ns = 0;
            for (cycle, pause_ns) in (1..).zip(pauses) {
                now_ns += pause_ns;
                prop_assert!(!watch.is_silent(now_ns, cycle));
            }
        }

        #[test]
        fn a_process_that_ended_is_noticed_by_an_observer_that_runs(
            pauses in prop::collection::vec(1_i64..=150, 1..200),
        ) {
            let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
            let mut now_ns = 0;
            for pause_ns in pauses {
                now_ns += pause_ns;
                prop_assert_eq!(watch.is_silent(now_ns, 0), now_ns > PERIOD_NS + TIMEOUT_NS);
            }
        }
    }
}
