//! One service of the group over all its processes: policy, budget, signs of life.

use super::drive::Sign;
use super::processes::{Process, describe};
use super::root::RunRoot;
use crate::Error;
use messages::Service;
use runtime::report::ServiceReport;
use scenario::supervision::{Restart, Supervision};
use serde::Serialize;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::time::Duration;

use super::events::Event;

/// Where a service is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Its process has not said yet that it is ready.
    Starting {
        /// Since when, run time in ns; negative before the start.
        since_ns: i64,
    },
    /// Its process takes part in the run.
    Running,
    /// Its process is gone; the next one is started at this run time, ns.
    Waiting {
        /// When.
        until_ns: i64,
    },
    /// It is not started again.
    GivenUp,
}

/// A service and its present process.
#[derive(Debug)]
pub struct Member {
    service: Service,
    program: Option<PathBuf>,
    process: Process,
    incarnation: u32,
    /// Where it is.
    pub phase: Phase,
    /// What it reported at its end.
    pub report: Option<ServiceReport>,
    /// Run time of the last sign of life, ns, and the cycles done then.
    sign: (i64, u64),
    /// Its signs of life over all its processes.
    pub heartbeats: Heartbeats,
    /// Run times of the restarts within the budget's window, ns.
    restarts: VecDeque<i64>,
}

/// Signs of life of a service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Heartbeats {
    /// How many.
    pub count: u64,
    /// In how many the service said of itself that some input was missing or stale.
    pub degraded: u64,
    /// Longest time without one, ms.
    pub longest_silence_ms: f64,
}

/// What the supervisor is to do about a death.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Start it again after so long.
    Restart(Duration),
    /// Its budget is used up: lead the vehicle into the safe state.
    GiveUp,
    /// Its policy ends the run.
    EndRun,
}

impl Member {
    /// Starts the first process of `service`.
    pub fn start(
        service: Service,
        program: Option<PathBuf>,
        root: &RunRoot,
        leader: i32,
        events: Sender<Event>,
    ) -> Result<Self, Error> {
        let process = Process::spawn((service, 0), program.as_ref(), root, leader, events)?;
        Ok(Self {
            service,
            program,
            process,
            incarnation: 0,
            phase: Phase::Starting { since_ns: -1 },
            report: None,
            sign: (0, 0),
            heartbeats: Heartbeats::default(),
            restarts: VecDeque::new(),
        })
    }

    /// Starts the next process in the place of the one that is gone.
    pub fn restart(
        &mut self,
        root: &RunRoot,
        leader: i32,
        events: Sender<Event>,
        now_ns: i64,
    ) -> Result<(), Error> {
        self.incarnation += 1;
        let identity = (self.service, self.incarnation);
        self.process = Process::spawn(identity, self.program.as_ref(), root, leader, events)?;
        self.phase = Phase::Starting { since_ns: now_ns };
        self.restarts.push_back(now_ns);
        Ok(())
    }

    /// The service.
    pub fn service(&self) -> Service {
        self.service
    }

    /// Which process of the service it is, counted from 0.
    pub fn incarnation(&self) -> u32 {
        self.incarnation
    }

    /// The present process.
    pub fn process(&mut self) -> &mut Process {
        &mut self.process
    }

    /// Process id.
    pub fn pid(&self) -> i32 {
        self.process.pid()
    }

    /// Process group of the present process.
    pub fn group(&self) -> i32 {
        self.process.group()
    }

    /// How the present process ended, waiting for it to be gone.
    pub fn how_it_ended(&mut self, grace: Duration) -> String {
        describe(self.process.end(grace))
    }

    /// Notes a sign of life at `now_ns` with so many cycles done; none without progress.
    pub fn sign_of_life(&mut self, sign: &Sign, now_ns: i64) {
        self.heartbeats.count += 1;
        self.heartbeats.degraded += u64::from(sign.degraded);
        let silent_ns = now_ns - self.sign.0;
        self.heartbeats.longest_silence_ms =
            self.heartbeats.longest_silence_ms.max(silent_ns as f64 / 1e6);
        if sign.incarnation == self.incarnation && sign.cycles > self.sign.1 {
            self.sign = (now_ns, sign.cycles);
        }
    }

    /// Counts the time without a sign of life from `now_ns` on.
    pub fn forgive(&mut self, now_ns: i64) {
        self.sign.0 = self.sign.0.max(now_ns);
    }

    /// It takes part from now on.
    pub fn begin(&mut self, now_ns: i64) {
        self.phase = Phase::Running;
        self.sign = (now_ns, 0);
    }

    /// Time without a sign of life, ns.
    pub fn silent_ns(&self, now_ns: i64) -> i64 {
        now_ns - self.sign.0
    }

    /// What to do now that its process is gone; `failed` if not by its own orderly end.
    pub fn verdict(&mut self, policy: &Supervision, failed: bool, now_ns: i64) -> Verdict {
        let window_ns = i64::try_from(policy.window_s.nanoseconds()).unwrap_or(i64::MAX);
        while self.restarts.front().is_some_and(|&then| now_ns - then > window_ns) {
            self.restarts.pop_front();
        }
        let row = self.restarts.len();
        match policy.restart_of(self.service) {
            Restart::Never => return Verdict::EndRun,
            Restart::OnFailure if !failed => return Verdict::EndRun,
            Restart::OnFailure | Restart::Always => {}
        }
        if row >= usize::from(policy.budget.value()) {
            return Verdict::GiveUp;
        }
        Verdict::Restart(backoff(policy, row))
    }
}

/// Wait before a restart that follows `row` others.
fn backoff(policy: &Supervision, row: usize) -> Duration {
    if row == 0 {
        return Duration::ZERO;
    }
    let doublings = u32::try_from(row - 1).unwrap_or(u32::MAX);
    let wait = u64::from(policy.backoff_ms.value()).saturating_mul(1 << doublings.min(30));
    Duration::from_millis(wait.min(policy.max_backoff_ms.value().into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_restart_is_at_once_and_the_wait_doubles_up_to_its_limit() {
        let policy = Supervision::default();
        let waits: Vec<u128> = (0..9).map(|row| backoff(&policy, row).as_millis()).collect();
        assert_eq!(waits, [0, 10, 20, 40, 80, 160, 320, 640, 1000]);
        assert_eq!(backoff(&policy, usize::MAX).as_millis(), 1000);
    }
}
