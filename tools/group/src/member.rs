//! One service of the group over all its processes: policy, budget, signs of life, accounts.

use super::drive::Sign;
use super::events::Event;
use super::exits::Exit;
use super::processes::Process;
use super::root::RunRoot;
use super::starvation::Share;
use crate::Error;
use messages::Service;
use runtime::report::ServiceReport;
use scenario::supervision::{Restart, Supervision};
use serde::Serialize;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::time::Duration;

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
    /// What it reported at the run's end.
    pub report: Option<ServiceReport>,
    /// What its processes before the present one counted.
    pub past: Vec<ServiceReport>,
    /// What the launcher killed the present process for, or how it ended during the run.
    cause: Option<Exit>,
    /// The present process has reported, before the run's end.
    has_told: bool,
    silence: Silence,
    /// Its signs of life over all its processes.
    pub heartbeats: Heartbeats,
    /// Run times of the restarts within the budget's window, ns.
    restarts: VecDeque<i64>,
}

/// The time since a service's last sign of life.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    /// Run time of the last sign of life, ns.
    heard_ns: i64,
    /// Cycles done then.
    cycles: u64,
    /// Run time from which it counts as silent, ns: later than `heard_ns` where the silence was the
    /// machine's or the launcher's.
    since_ns: i64,
    /// What it had of the processor at a run time within the silence, ns.
    suspect: Option<(i64, Share)>,
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
    /// Time without one because the machine did not give it the processor, ms.
    pub starved_ms: f64,
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
            past: Vec::new(),
            cause: None,
            has_told: false,
            silence: Silence::default(),
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
        (self.cause, self.has_told) = (None, false);
        self.phase = Phase::Starting { since_ns: now_ns };
        self.restarts.push_back(now_ns);
        Ok(())
    }

    /// The next process takes part from now on.
    pub fn begin(&mut self, now_ns: i64) {
        self.phase = Phase::Running;
        self.silence = Silence { heard_ns: now_ns, since_ns: now_ns, ..Silence::default() };
    }

    /// Kills the present process, which is said to have ended so.
    pub fn kill(&mut self, cause: Exit) {
        self.cause.get_or_insert(cause);
        self.process.kill();
    }

    /// Notes that the present process leaves by itself, before the run's end, with this report.
    pub fn leaves_early(&mut self, report: ServiceReport) {
        self.past.push(report);
        self.has_told = true;
    }

    /// Keeps what the present process, which is gone, left, unless it told that itself.
    pub fn keep(&mut self, left: ServiceReport) {
        if !self.has_told {
            self.past.push(left);
        }
    }

    /// How the present process ended; one that lives on after `grace` is killed and has ended as
    /// `overdue`.
    pub fn exit(&mut self, grace: Duration, overdue: Exit) -> Exit {
        let (status, killed) = self.process.end(grace);
        match (self.cause, Exit::of(status)) {
            (Some(cause), _) => cause,
            (None, _) if killed => overdue,
            (None, exit) => exit,
        }
    }

    /// How the present process ended, which closed its output before the run's end; it is killed if it
    /// lives on after `grace`.
    pub fn exit_in_run(&mut self, grace: Duration) -> Exit {
        let exit = match self.exit(grace, Exit::OutputClosed) {
            Exit::Ok => Exit::Early,
            other => other,
        };
        self.cause = Some(exit);
        exit
    }

    /// Notes a sign of life at `now_ns` with so many cycles done; none without progress.
    pub fn sign_of_life(&mut self, sign: &Sign, now_ns: i64) {
        self.heartbeats.count += 1;
        self.heartbeats.degraded += u64::from(sign.degraded);
        let silent_ms = (now_ns - self.silence.heard_ns) as f64 / 1e6;
        self.heartbeats.longest_silence_ms = self.heartbeats.longest_silence_ms.max(silent_ms);
        if sign.incarnation == self.incarnation && sign.cycles > self.silence.cycles {
            self.silence =
                Silence { heard_ns: now_ns, cycles: sign.cycles, since_ns: now_ns, suspect: None };
        }
    }

    /// Counts the time without a sign of life from `now_ns` on.
    pub fn reset_silence(&mut self, now_ns: i64) {
        self.silence.since_ns = self.silence.since_ns.max(now_ns);
        self.silence.suspect = None;
    }

    /// True if the service hangs: no sign of life for more than `limit_ns`, although the machine gave
    /// it the processor.
    pub fn is_hung(&mut self, now_ns: i64, limit_ns: i64) -> bool {
        let silent_ns = now_ns - self.silence.since_ns;
        if 2 * silent_ns > limit_ns && self.silence.suspect.is_none() {
            self.silence.suspect = Share::of(self.pid()).map(|share| (now_ns, share));
        }
        if silent_ns <= limit_ns {
            return false;
        }
        let Some((then_ns, before)) = self.silence.suspect else { return true };
        let starved = Share::of(self.pid())
            .is_some_and(|share| before.is_starved(share, (now_ns - then_ns).max(1)));
        if starved {
            self.heartbeats.starved_ms += silent_ns as f64 / 1e6;
            self.reset_silence(now_ns);
        }
        !starved
    }

    /// True if the next process should be ready by now: it was started before `limit_ns`, and the
    /// machine gave it the processor.
    pub fn is_overdue(&mut self, now_ns: i64, limit_ns: i64) -> bool {
        let Phase::Starting { since_ns } = self.phase else { return false };
        let waited_ns = now_ns - since_ns;
        if waited_ns <= limit_ns {
            return false;
        }
        let starved = Share::of(self.pid())
            .is_some_and(|share| Share::default().is_starved(share, waited_ns));
        if starved {
            self.heartbeats.starved_ms += waited_ns as f64 / 1e6;
            self.phase = Phase::Starting { since_ns: now_ns };
        }
        !starved
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

    /// The present process.
    pub fn process(&mut self) -> &mut Process {
        &mut self.process
    }

    /// The service.
    pub fn service(&self) -> Service {
        self.service
    }

    /// Which process of the service it is, counted from 0.
    pub fn incarnation(&self) -> u32 {
        self.incarnation
    }

    /// Process id.
    pub fn pid(&self) -> i32 {
        self.process.pid()
    }

    /// Process group of the present process.
    pub fn group(&self) -> i32 {
        self.process.group()
    }

    /// Run time of the last sign of life, ns.
    pub fn heard_ns(&self) -> i64 {
        self.silence.heard_ns
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
