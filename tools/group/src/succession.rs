//! Who follows whom in a service: its active process, its standby, and what is due next.
//!
//! A pure state machine: events in, steps out, time an argument. Processes are told apart by their
//! incarnation. One that is neither active nor standby any more was replaced; its end means nothing.
//!
//! ```text
//! active:   Starting ─ ready ─► Running ─ gone, standby ready ────► Vacant ─ took over ─► Running
//!                                  │ └──── gone, standby starting ► Starting (the standby becomes active)
//!                                  └────── gone, no standby ──────► Waiting ─ due ─► Starting
//!                                                                   GivenUp, if the budget is used up
//! standby:  Absent ─ due ─► Starting ─ ready ─► Ready ─ took over, or gone ─► Absent
//! ```
//!
//! The standby decides by itself when it takes over (by a compare-and-swap, `runtime`); what is here follows.
//! So the end of the active process and the take-over arrive in either order, and a standby may end in the
//! middle of its take-over: each of these is a line of [`Succession::on`].

use scenario::supervision::{Restart, Supervision};
use std::collections::VecDeque;
use std::time::Duration;

/// A standby that has not taken over so long after the active process's end is killed, ns.
const TAKE_OVER_LIMIT_NS: i64 = 250_000_000;

/// Where a service is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Its active process has not said yet that it is ready.
    Starting {
        /// Since when, run time in ns; negative before the start.
        since_ns: i64,
    },
    /// Its active process takes part in the run.
    Running,
    /// Its active process is gone; the standby is about to take over.
    Vacant {
        /// Since when, run time in ns.
        since_ns: i64,
    },
    /// Its active process is gone; the next one is started at this run time, ns.
    Waiting {
        /// When.
        until_ns: i64,
    },
    /// It is not started again.
    GivenUp,
}

/// The second process of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standby {
    /// The scenario asks for none.
    Unwanted,
    /// There is none; the next one is started at this run time, ns.
    Absent {
        /// When.
        until_ns: i64,
    },
    /// It has not said yet that it is ready.
    Starting {
        /// Which process it is.
        incarnation: u32,
        /// Since when, run time in ns.
        since_ns: i64,
    },
    /// It stands by for the active process.
    Ready {
        /// Which process it is.
        incarnation: u32,
    },
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

/// What happened to a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Its ports are open.
    Ready(u32),
    /// It was the standby, and took over.
    TookOver(u32),
    /// It ended; `failed` if not by its own orderly end.
    Gone {
        /// Which process.
        incarnation: u32,
        /// How.
        failed: bool,
    },
    /// Time has passed.
    Tick,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Start this process; as the active one or as a standby it will be told when it is ready.
    Start(u32),
    /// Let this process, which is ready, into the run as the active one.
    Activate(u32),
    /// Let this process, which is ready, stand by for another one.
    StandBy {
        /// The standby.
        incarnation: u32,
        /// The active process.
        active: u32,
    },
    /// Tell this standby that the active process is gone.
    OrderTakeOver(u32),
    /// This process has become the active one.
    Replaced {
        /// The one before it, which may live on.
        old: u32,
        /// The active one.
        new: u32,
    },
    /// Kill this standby: it does not do what it is there for.
    Kill(u32),
    /// The budget is used up.
    GiveUp,
    /// The policy ends the run.
    EndRun,
}

/// The processes of one service.
#[derive(Clone, Debug)]
pub struct Succession {
    policy: Supervision,
    restart: Restart,
    active: u32,
    /// Where its active process is.
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
    pub fn new(policy: &Supervision, service: messages::Service, with_standby: bool) -> Self {
        Self {
            policy: *policy,
            restart: policy.restart_of(service),
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

    /// The standby.
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

    /// In how many of these the standby took over.
    pub fn take_overs(&self) -> u32 {
        self.take_overs
    }

    /// What follows from `event` at `now_ns`; the steps are appended to `steps`.
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
            Standby::Ready { incarnation } => {
                self.phase = Phase::Vacant { since_ns: now_ns };
                steps.push(Step::OrderTakeOver(incarnation));
            }
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
        self.phase = Phase::Waiting { until_ns: after(now_ns, backoff(&self.policy, row)) };
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
        Standby::Absent { until_ns: after(now_ns, backoff(&self.policy, row)) }
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

/// Wait before a start that follows `row` others.
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
    use messages::Service;
    use proptest::prelude::*;
    use std::collections::{BTreeMap, VecDeque};

    const MS: i64 = 1_000_000;

    #[test]
    fn the_first_restart_is_at_once_and_the_wait_doubles_up_to_its_limit() {
        let policy = Supervision::default();
        let waits: Vec<u128> = (0..9).map(|row| backoff(&policy, row).as_millis()).collect();
        assert_eq!(waits, [0, 10, 20, 40, 80, 160, 320, 640, 1000]);
        assert_eq!(backoff(&policy, usize::MAX).as_millis(), 1000);
    }

    fn machine() -> Succession {
        let mut machine = Succession::new(&Supervision::default(), Service::Controller, true);
        let mut steps = Vec::new();
        machine.on(Event::Ready(0), 0, &mut steps);
        machine.on(Event::Ready(1), 0, &mut steps);
        assert_eq!(steps, [Step::Activate(0), Step::StandBy { incarnation: 1, active: 0 }]);
        machine
    }

    fn steps(machine: &mut Succession, event: Event, now_ns: i64) -> Vec<Step> {
        let mut steps = Vec::new();
        machine.on(event, now_ns, &mut steps);
        steps
    }

    const fn gone(incarnation: u32) -> Event {
        Event::Gone { incarnation, failed: true }
    }

    #[test]
    fn end_and_take_over_may_come_in_either_order() {
        for take_over_first in [false, true] {
            let mut machine = machine();
            let replaced = vec![Step::Replaced { old: 0, new: 1 }];
            if take_over_first {
                assert_eq!(steps(&mut machine, Event::TookOver(1), MS), replaced);
                assert_eq!(steps(&mut machine, gone(0), MS), []);
            } else {
                assert_eq!(steps(&mut machine, gone(0), MS), [Step::OrderTakeOver(1)]);
                assert_eq!(steps(&mut machine, Event::TookOver(1), MS), replaced);
            }
            assert_eq!((machine.active(), machine.phase), (1, Phase::Running));
            assert_eq!(steps(&mut machine, Event::Tick, MS), [Step::Start(2)]);
        }
    }

    #[test]
    fn both_processes_may_end_at_once() {
        for order in [[gone(0), gone(1)], [gone(1), gone(0)]] {
            let mut machine = machine();
            order.into_iter().for_each(|event| drop(steps(&mut machine, event, MS)));
            assert_eq!(steps(&mut machine, Event::Tick, MS), [Step::Start(2)]);
            assert_eq!(steps(&mut machine, Event::Ready(2), MS), [Step::Activate(2)]);
            assert_eq!(steps(&mut machine, Event::Tick, 20 * MS), [Step::Start(3)]);
        }
    }

    #[test]
    fn a_standby_that_does_not_take_over_is_killed_and_a_starting_one_becomes_active() {
        let mut machine = machine();
        drop(steps(&mut machine, gone(0), 0));
        assert_eq!(steps(&mut machine, Event::Tick, 300 * MS), [Step::Kill(1)]);
        assert_eq!(steps(&mut machine, gone(1), 301 * MS), []);
        assert_eq!(steps(&mut machine, Event::Tick, 301 * MS), [Step::Start(2)]);
        drop(steps(&mut machine, Event::Ready(2), 310 * MS));
        assert_eq!(steps(&mut machine, Event::Tick, 400 * MS), [Step::Start(3)]);
        assert_eq!(steps(&mut machine, gone(2), 401 * MS), []);
        assert_eq!(steps(&mut machine, Event::Ready(3), 402 * MS), [Step::Activate(3)]);
    }

    #[test]
    fn standbys_leave_a_restart_to_the_active_process() {
        let mut machine = machine();
        for standby in 1..=5 {
            drop(steps(&mut machine, gone(standby), i64::from(standby) * 100 * MS));
            let started = steps(&mut machine, Event::Tick, i64::from(standby) * 100 * MS + 90 * MS);
            assert_eq!(started.len(), usize::from(standby < 5), "{standby}");
        }
        drop(steps(&mut machine, gone(0), 700 * MS));
        assert_eq!(steps(&mut machine, Event::Tick, 1_000 * MS), [Step::Start(6)]);
    }

    /// A process of the world that the machine supervises.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Process {
        Starting,
        Active,
        StandingBy { active: u32 },
    }

    /// Processes, the epoch, and events on their way: in order for each process, in any order between them.
    struct World {
        machine: Succession,
        processes: BTreeMap<u32, Process>,
        on_their_way: BTreeMap<u32, VecDeque<Event>>,
        epoch: u32,
        now_ns: i64,
        given_up: bool,
    }

    impl World {
        fn new() -> Self {
            let processes = [(0, Process::Starting), (1, Process::Starting)].into();
            let policy = Supervision::default();
            let machine = Succession::new(&policy, Service::Controller, true);
            let on_their_way = BTreeMap::new();
            Self { machine, processes, on_their_way, epoch: 0, now_ns: 0, given_up: false }
        }

        fn say(&mut self, incarnation: u32, event: Event) {
            self.on_their_way.entry(incarnation).or_default().push_back(event);
        }

        fn end(&mut self, incarnation: u32) {
            if self.processes.remove(&incarnation).is_some() {
                self.say(incarnation, gone(incarnation));
            }
        }

        fn take_over(&mut self, incarnation: u32) {
            let Some(Process::StandingBy { active }) = self.processes.get(&incarnation) else {
                return;
            };
            if self.epoch == *active {
                self.epoch = incarnation;
                self.processes.insert(incarnation, Process::Active);
                self.say(incarnation, Event::TookOver(incarnation));
            }
        }

        fn apply(&mut self, event: Event) {
            let mut steps = Vec::new();
            self.machine.on(event, self.now_ns, &mut steps);
            for step in steps {
                assert!(!self.given_up, "{step:?} after giving up");
                match step {
                    Step::Start(i) => {
                        assert!(self.processes.insert(i, Process::Starting).is_none())
                    }
                    Step::Activate(i) => {
                        if let Some(process) = self.processes.get_mut(&i) {
                            *process = Process::Active;
                            self.epoch = self.epoch.max(i);
                        }
                    }
                    Step::StandBy { incarnation, active } => {
                        if let Some(process) = self.processes.get_mut(&incarnation) {
                            *process = Process::StandingBy { active };
                        }
                    }
                    Step::OrderTakeOver(i) => self.take_over(i),
                    Step::Replaced { old, .. } => self.end(old),
                    Step::Kill(i) => self.end(i),
                    Step::GiveUp => self.given_up = true,
                    Step::EndRun => panic!("the policy is to go on"),
                }
            }
        }

        /// One random thing: what of it is possible.
        fn happen(&mut self, what: u8, which: usize) {
            let pick = |from: Vec<u32>| (!from.is_empty()).then(|| from[which % from.len()]);
            let alive: Vec<u32> = self.processes.keys().copied().collect();
            match what % 8 {
                0 => pick(alive).into_iter().for_each(|i| self.end(i)),
                1 => {
                    let starting = self.processes.iter().filter(|(_, p)| **p == Process::Starting);
                    let starting: Vec<u32> = starting.map(|(i, _)| *i).collect();
                    // What was said already is on its way.
                    let waits = |i: &u32| self.on_their_way.get(i).is_none_or(VecDeque::is_empty);
                    let next = pick(starting.into_iter().filter(waits).collect());
                    next.into_iter().for_each(|i| self.say(i, Event::Ready(i)));
                }
                // By the end of the active process, or since it is silent: the standby's own decision.
                2 => pick(alive).into_iter().for_each(|i| self.take_over(i)),
                3 => {
                    self.now_ns += 20 * MS;
                    self.apply(Event::Tick);
                }
                _ => {
                    let full = self.on_their_way.iter().filter(|(_, events)| !events.is_empty());
                    let full: Vec<u32> = full.map(|(i, _)| *i).collect();
                    let next = pick(full).and_then(|i| self.on_their_way.get_mut(&i)?.pop_front());
                    next.into_iter().for_each(|event| self.apply(event));
                }
            }
        }

        /// No more faults: everything that is on its way arrives, and time passes.
        fn settle(&mut self) {
            for _ in 0..200 {
                let vacant = !self.processes.contains_key(&self.epoch);
                for (i, process) in self.processes.clone() {
                    match process {
                        Process::Starting => self.say(i, Event::Ready(i)),
                        Process::StandingBy { .. } if vacant => self.take_over(i),
                        _ => {}
                    }
                }
                while let Some(event) = self.on_their_way.values_mut().find_map(VecDeque::pop_front)
                {
                    self.apply(event);
                }
                self.now_ns += 100 * MS;
                self.apply(Event::Tick);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]
        #[test]
        fn every_order_of_events_ends_with_an_active_process_and_its_standby_or_a_used_up_budget(
            history in prop::collection::vec((any::<u8>(), any::<usize>()), 0..120),
        ) {
            let mut world = World::new();
            for (what, which) in history {
                world.happen(what, which);
            }
            world.settle();
            if world.given_up {
                prop_assert_eq!(world.machine.phase, Phase::GivenUp);
                return Ok(());
            }
            let active = world.machine.active();
            prop_assert_eq!(world.machine.phase, Phase::Running);
            prop_assert_eq!(world.processes.get(&active), Some(&Process::Active));
            prop_assert_eq!(world.epoch, active, "the active process has the epoch");
            let standby = world.machine.standby();
            let Standby::Ready { incarnation } = standby else {
                panic!("no standby in the end: {standby:?}");
            };
            let stands_by = Process::StandingBy { active };
            prop_assert_eq!(world.processes.get(&incarnation), Some(&stands_by));
            prop_assert_eq!(world.processes.len(), 2, "{:?}", world.processes);
        }
    }
}
