//! The order of a service's processes: its active process, its standby, and what is due next.
//!
//! A pure state machine: events in, steps out, time an argument. The incarnation identifies a process. One that is
//! neither active nor standby any more was replaced; its end means nothing.
//!
//! ```text
//! active:   Starting ─ ready ─► Running ─ gone, standby ready ────► Vacant ─ took over ─► Running
//!                                  │ └──── gone, standby starting ► Starting (the standby becomes active)
//!                                  └────── gone, no standby ──────► Waiting ─ due ─► Starting
//!                                                                   GivenUp, if the budget is used up
//! standby:  Absent ─ due ─► Starting ─ ready ─► Ready ─ took over, or gone ─► Absent
//! ```
//!
//! The standby alone decides when it takes over (by a compare-and-swap, `runtime`); what is here follows. So the
//! end of the active process and the take-over arrive in either order. A standby may end in the middle of its
//! take-over: each of these is a line of [`Succession::on`].

use scenario::supervision::{Restart, Supervision};
use std::collections::VecDeque;
use std::time::Duration;

/// Time after the active process's end within which a standby has to take over, ns; then it is killed.
const TAKE_OVER_LIMIT_NS: i64 = 250_000_000;

/// Phase of a service's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Its active process has not said yet that it is ready.
    Starting {
        /// Start of the phase, run time in ns; negative before the start.
        since_ns: i64,
    },
    /// Its active process takes part in the run.
    Running,
    /// Its active process is gone; the standby is about to take over.
    Vacant {
        /// Start of the phase, run time in ns.
        since_ns: i64,
    },
    /// Its active process is gone; the next one is started at this run time, ns.
    Waiting { until_ns: i64 },
    /// It is not started again.
    GivenUp,
}

/// The second process of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standby {
    /// The scenario does not ask for one.
    Unwanted,
    /// Absent; the next one is started at this run time, ns.
    Absent { until_ns: i64 },
    /// It has not said yet that it is ready.
    Starting {
        incarnation: u32,
        /// Start of the phase, run time in ns.
        since_ns: i64,
    },
    /// It stands by for the active process.
    Ready { incarnation: u32 },
}

impl Standby {
    /// The process, if there is one.
    pub fn incarnation(self) -> Option<u32> {
        match self {
            Self::Starting { incarnation, .. } | Self::Ready { incarnation } => Some(incarnation),
            Self::Unwanted | Self::Absent { .. } => None,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Its ports are open.
    Ready(u32),
    /// It was the standby, and took over.
    TookOver(u32),
    /// It ended; `failed` if not by its own orderly end.
    Gone { incarnation: u32, failed: bool },
    /// Time has passed.
    Tick,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Start this process; it becomes the active one or a standby when it is ready.
    Start(u32),
    /// Let this process, which is ready, into the run as the active one.
    Activate(u32),
    /// Let this process, which is ready, stand by for another one.
    StandBy {
        incarnation: u32,
        active: u32,
    },
    /// This process has become the active one.
    Replaced {
        /// The one before it, which may live on.
        old: u32,
        new: u32,
    },
    /// Kill this standby: it does not do what it is there for.
    Kill(u32),
    /// The budget is used up.
    GiveUp,
    EndRun,
}

/// The processes of one service.
#[derive(Clone, Debug)]
pub struct Succession {
    policy: Supervision,
    restart: Restart,
    active: u32,
    /// Phase of its active process.
    pub phase: Phase,
    standby: Standby,
    newest: u32,
    /// Times that another process became the active one.
    replacements: u32,
    take_overs: u32,
    /// Run times of the starts after the first ones, within the budget's window, ns.
    starts: VecDeque<i64>,
}

impl Succession {
    /// The first processes of a service, which are starting.
    pub fn new(policy: &Supervision, restart: Restart, with_standby: bool) -> Self {
        Self {
            policy: policy.clone(),
            restart,
            active: 0,
            phase: Phase::Starting { since_ns: -1 },
            standby: match with_standby {
                true => Standby::Starting { incarnation: 1, since_ns: -1 },
                false => Standby::Unwanted,
            },
            newest: u32::from(with_standby),
            replacements: 0,
            take_overs: 0,
            starts: VecDeque::new(),
        }
    }

    /// The active process, or the last one there was.
    pub fn active(&self) -> u32 {
        self.active
    }

    pub fn standby(&self) -> Standby {
        self.standby
    }

    /// The process that would be started next.
    pub fn next(&self) -> u32 {
        self.newest + 1
    }

    /// True if a process that fails is replaced.
    pub fn replaces(&self) -> bool {
        self.restart != Restart::Never
    }

    /// Counts the time of a start from `now_ns` on.
    pub fn wait_longer(&mut self, now_ns: i64) {
        match (&mut self.phase, &mut self.standby) {
            (Phase::Starting { since_ns }, _) | (_, Standby::Starting { since_ns, .. }) => {
                *since_ns = now_ns;
            }
            _ => {}
        }
    }

    /// Times that another process became the active one.
    pub fn replacements(&self) -> u32 {
        self.replacements
    }

    /// Number of these in which the standby took over.
    pub fn take_overs(&self) -> u32 {
        self.take_overs
    }

    /// Takes `event` at `now_ns` and appends the steps that follow from it to `steps`.
    pub fn on(&mut self, event: Event, now_ns: i64, steps: &mut Vec<Step>) {
        match event {
            Event::Ready(incarnation) => self.on_ready(incarnation, steps),
            Event::TookOver(incarnation) => self.on_take_over(incarnation, now_ns, steps),
            Event::Gone { incarnation, failed } if incarnation == self.active => {
                self.on_active_gone(failed, now_ns, steps);
            }
            Event::Gone { incarnation, .. } if self.standby.incarnation() == Some(incarnation) => {
                self.on_standby_gone(now_ns, steps);
            }
            // It was replaced before.
            Event::Gone { .. } => {}
            Event::Tick => self.on_tick(now_ns, steps),
        }
    }

    fn on_ready(&mut self, incarnation: u32, steps: &mut Vec<Step>) {
        if incarnation == self.active && matches!(self.phase, Phase::Starting { .. }) {
            self.phase = Phase::Running;
            steps.push(Step::Activate(incarnation));
        } else if matches!(self.standby, Standby::Starting { incarnation: i, .. } if i == incarnation)
        {
            self.standby = Standby::Ready { incarnation };
            steps.push(Step::StandBy { incarnation, active: self.active });
        }
    }

    fn on_take_over(&mut self, incarnation: u32, now_ns: i64, steps: &mut Vec<Step>) {
        // Only a process that stands by can take over, and none but the newest does.
        if self.standby != (Standby::Ready { incarnation }) {
            return;
        }
        steps.push(Step::Replaced { old: self.active, new: incarnation });
        self.active = incarnation;
        self.phase = Phase::Running;
        self.replacements += 1;
        self.take_overs += 1;
        self.standby = self.absent(now_ns);
    }

    fn on_active_gone(&mut self, failed: bool, now_ns: i64, steps: &mut Vec<Step>) {
        if self.restart == Restart::Never || (self.restart == Restart::OnFailure && !failed) {
            steps.push(Step::EndRun);
            return;
        }
        match self.standby {
            // It sees the end itself.
            Standby::Ready { .. } => self.phase = Phase::Vacant { since_ns: now_ns },
            Standby::Starting { incarnation, since_ns } => {
                self.active = incarnation;
                self.replacements += 1;
                self.phase = Phase::Starting { since_ns };
                self.standby = self.absent(now_ns);
            }
            Standby::Absent { .. } | Standby::Unwanted => self.start_cold(now_ns, steps),
        }
    }

    fn on_standby_gone(&mut self, now_ns: i64, steps: &mut Vec<Step>) {
        self.standby = self.absent(now_ns);
        if matches!(self.phase, Phase::Vacant { .. }) {
            self.start_cold(now_ns, steps);
        }
    }

    fn on_tick(&mut self, now_ns: i64, steps: &mut Vec<Step>) {
        match self.phase {
            Phase::Waiting { until_ns } if until_ns <= now_ns => {
                self.active = self.start(now_ns, steps);
                self.replacements += 1;
                self.phase = Phase::Starting { since_ns: now_ns };
            }
            Phase::Vacant { since_ns } if now_ns - since_ns > TAKE_OVER_LIMIT_NS => {
                // Its end is the next event.
                steps.extend(self.standby.incarnation().map(Step::Kill));
            }
            Phase::Running => self.start_standby(now_ns, steps),
            _ => {}
        }
    }

    /// Starts a standby that is due, unless that would leave the active process without a restart.
    fn start_standby(&mut self, now_ns: i64, steps: &mut Vec<Step>) {
        let Standby::Absent { until_ns } = self.standby else { return };
        if until_ns <= now_ns && self.row(now_ns) + 1 < usize::from(self.policy.budget.value()) {
            let incarnation = self.start(now_ns, steps);
            self.standby = Standby::Starting { incarnation, since_ns: now_ns };
        }
    }

    /// The next active process is started where none lives, within the budget.
    fn start_cold(&mut self, now_ns: i64, steps: &mut Vec<Step>) {
        let row = self.row(now_ns);
        if row >= usize::from(self.policy.budget.value()) {
            self.phase = Phase::GivenUp;
            steps.push(Step::GiveUp);
            return;
        }
        self.phase = Phase::Waiting { until_ns: after(now_ns, self.policy.backoff(row)) };
    }

    fn start(&mut self, now_ns: i64, steps: &mut Vec<Step>) -> u32 {
        self.newest += 1;
        self.starts.push_back(now_ns);
        steps.push(Step::Start(self.newest));
        self.newest
    }

    /// No standby from now on; the next one is due after the wait that restarts in a row ask for.
    fn absent(&mut self, now_ns: i64) -> Standby {
        let row = self.row(now_ns);
        Standby::Absent { until_ns: after(now_ns, self.policy.backoff(row)) }
    }

    /// Starts within the budget's window.
    fn row(&mut self, now_ns: i64) -> usize {
        let window_ns = i64::try_from(self.policy.window_s.nanoseconds()).unwrap_or(i64::MAX);
        while self.starts.front().is_some_and(|&then| now_ns - then > window_ns) {
            self.starts.pop_front();
        }
        self.starts.len()
    }
}

fn after(now_ns: i64, wait: Duration) -> i64 {
    now_ns.saturating_add(i64::try_from(wait.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests;
