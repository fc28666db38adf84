use super::*;
use proptest::prelude::*;
use std::collections::{BTreeMap, VecDeque};

const MS: i64 = 1_000_000;

#[test]
fn the_first_restart_is_at_once_and_the_wait_doubles_up_to_its_limit() {
    let policy = Supervision::default();
    let waits: Vec<u128> = (0..9).map(|row| policy.backoff(row).as_millis()).collect();
    assert_eq!(waits, [0, 10, 20, 40, 80, 160, 320, 640, 1000]);
    assert_eq!(policy.backoff(usize::MAX).as_millis(), 1000);
}

fn machine() -> Succession {
    let mut machine = Succession::new(&Supervision::default(), Restart::OnFailure, true);
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
            assert_eq!(steps(&mut machine, gone(0), MS), []);
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
        let machine = Succession::new(&policy, policy.restart, true);
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
                // Earlier messages are on their way.
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
            while let Some(event) = self.on_their_way.values_mut().find_map(VecDeque::pop_front) {
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
