//! Run time: nanoseconds since the group's common start instant.

use rustix::time::{ClockId, Timespec, clock_gettime};
use serde::{Deserialize, Serialize};
use std::cell::Cell;

/// Clock of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// `CLOCK_MONOTONIC`.
    Realtime,
    /// Simulated time, as fast as the machine goes.
    Lockstep,
}

impl Mode {
    /// Name on the command line and in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Realtime => "realtime",
            Self::Lockstep => "lockstep",
        }
    }
}

/// `CLOCK_MONOTONIC` in ns: comparable between processes of one host.
pub fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// Sleeps until `CLOCK_MONOTONIC` reads `instant_ns`, or a signal arrives.
pub fn sleep_until(instant_ns: i64) {
    let until = Timespec {
        tv_sec: instant_ns.div_euclid(1_000_000_000),
        tv_nsec: instant_ns.rem_euclid(1_000_000_000),
    };
    // An early return is a signal: the caller looks at the time and at the stop order again.
    let _ = rustix::thread::clock_nanosleep_absolute(ClockId::Monotonic, &until);
}

/// The group's clock as one service sees it.
#[derive(Debug)]
pub struct Clock {
    pub mode: Mode,
    step_ns: i64,
    start_ns: Cell<i64>,
    simulated_ns: Cell<i64>,
    step: Cell<u64>,
}

impl Clock {
    /// A clock whose steps are `step_ns` long; run time begins when the group starts.
    pub fn new(mode: Mode, step_ns: i64) -> Self {
        let start_ns = Cell::new(monotonic_ns());
        Self { mode, step_ns, start_ns, simulated_ns: Cell::new(0), step: Cell::new(0) }
    }

    /// Sets the common start instant, in `CLOCK_MONOTONIC` ns.
    pub(crate) fn start(&self, start_ns: i64) {
        self.start_ns.set(start_ns);
    }

    /// The step of the service's present release.
    pub(crate) fn step(&self) -> u64 {
        self.step.get()
    }

    pub(crate) fn set_step(&self, step: u64) {
        self.step.set(step);
        self.simulated_ns.set(self.scheduled_ns(step));
    }

    /// Sets the simulated time to an instant between steps: for what is replayed.
    pub(crate) fn set_simulated(&self, now_ns: i64) {
        self.simulated_ns.set(now_ns);
    }

    /// Now, in run time: the wall's in realtime, the current step's in lockstep.
    pub fn now_ns(&self) -> i64 {
        match self.mode {
            Mode::Realtime => monotonic_ns() - self.start_ns.get(),
            Mode::Lockstep => self.simulated_ns.get(),
        }
    }

    /// Scheduled instant of `step`, in run time.
    pub fn scheduled_ns(&self, step: u64) -> i64 {
        self.step_ns * i64::try_from(step).expect("a run has fewer than 2^63 steps")
    }

    /// Sleeps until the scheduled instant of `step`, or a signal.
    pub(crate) fn sleep_until(&self, step: u64) {
        sleep_until(self.start_ns.get() + self.scheduled_ns(step));
    }
}
