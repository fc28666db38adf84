//! Choice of the faults that act on a message, and their counts.

use messages::{EgoTruth, Message, Role, Service, Topic};
use scenario::Scenario;
use scenario::faults::{Effect, Falsification, Fault, Target};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::mpsc::Receiver;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// A fault that the launcher sends into a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Injected {
    pub number: u32,
    /// Time when it begins, ns of run time.
    pub begin_ns: i64,
    pub fault: Fault,
}

/// Number of messages in a service's ports on which a fault acted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultStatistics {
    /// The fault's number in the run.
    pub fault: u32,
    /// Time when it began, ns of run time.
    pub begun_ns: i64,
    pub messages: u64,
    /// Messages that it corrupted and a receiver took for intact.
    #[serde(default)]
    pub undetected: u64,
}

/// A fault and what became of it.
#[derive(Clone, Debug)]
struct Entry {
    number: u32,
    fault: Fault,
    begun_ns: Option<i64>,
    messages: u64,
    undetected: u64,
}

/// The faults of a run, as one service's ports see them.
#[derive(Debug)]
pub(crate) struct Faults {
    seed: u64,
    entries: RefCell<Vec<Entry>>,
    /// Faults that the launcher sends during the run.
    injected: Option<Receiver<Injected>>,
}

/// One fault at the moment it acts on a message.
pub(crate) struct Activation {
    /// The fault's number in the run.
    pub(crate) number: u32,
    /// 64 random bits, those of this fault and this message.
    pub(crate) random: u64,
}

impl Activation {
    /// Another 64 random bits.
    pub(crate) fn draw(&self, k: u64) -> u64 {
        xxh3_64_with_seed(&k.to_le_bytes(), self.random)
    }
}

impl Faults {
    /// The faults of `scenario` that act on messages, and those that are `injected` during the run.
    pub(crate) fn of(scenario: &Scenario, injected: Option<Receiver<Injected>>) -> Self {
        let entry = |(number, fault): (usize, &Fault)| Entry {
            number: u32::try_from(number).expect("faults are few"),
            fault: fault.clone(),
            begun_ns: fault.begin.known_ns(),
            messages: 0,
            undetected: 0,
        };
        let entries = scenario.faults.iter().enumerate();
        let entries = entries.filter(|(_, fault)| fault.effect.extent().is_some()).map(entry);
        let entries = RefCell::new(entries.collect());
        Self { seed: scenario.seed.value(), entries, injected }
    }

    /// True if one may come to act on messages of `topic`, those aside that the launcher still sends.
    pub(crate) fn concern(&self, topic: Topic) -> bool {
        self.reach(topic, |_| true)
    }

    /// True if such a fault may act on messages of `topic`.
    pub(crate) fn reach(&self, topic: Topic, which: impl Fn(&Effect) -> bool) -> bool {
        self.entries.borrow().iter().map(|entry| &entry.fault.effect).any(|effect| {
            which(effect)
                && match effect.target() {
                    Target::Topic(aimed) => aimed == topic,
                    Target::Service(_) => true,
                    Target::Helper(_) | Target::Machine => false,
                }
        })
    }

    /// Takes in the faults that the launcher sent.
    pub(crate) fn refresh(&self) {
        for Injected { number, begin_ns, fault } in
            self.injected.iter().flat_map(Receiver::try_iter)
        {
            let (begun_ns, messages, undetected) = (Some(begin_ns), 0, 0);
            let entry = Entry { number, fault, begun_ns, messages, undetected };
            self.entries.borrow_mut().push(entry);
        }
    }

    pub(crate) fn waits_for_the_drive(&self) -> bool {
        self.entries.borrow().iter().any(|entry| entry.fault.begin.when.is_some())
    }

    /// Begins the faults whose condition the drive fulfils.
    pub(crate) fn observe<'a>(&self, drive: impl FnOnce() -> Option<&'a EgoTruth>, now_ns: i64) {
        let mut entries = self.entries.borrow_mut();
        let mut waiting = entries.iter_mut().filter(|entry| entry.begun_ns.is_none()).peekable();
        let Some(drive) = waiting.peek().is_some().then(drive).flatten() else { return };
        for entry in waiting.filter(|entry| entry.fault.begin.is_met(drive)) {
            entry.begun_ns = Some(now_ns);
        }
    }

    /// Calls `each` with every fault that `which` picks and that acts on message `sequence` of `source`
    /// on `topic` at `now_ns`.
    pub(crate) fn activate<F>(
        &self,
        which: impl Fn(&Effect) -> Option<&F>,
        topic: Topic,
        (source, incarnation, sequence): (u32, u32, u64),
        now_ns: i64,
        mut each: impl FnMut(&F, &Activation),
    ) {
        if topic.role() == Role::Truth {
            return;
        }
        for entry in self.entries.borrow_mut().iter_mut() {
            let effect = &entry.fault.effect;
            let (Some(begun_ns), Some(fault), Some(extent)) =
                (entry.begun_ns, which(effect), effect.extent())
            else {
                continue;
            };
            if !is_aimed(effect, topic, source)
                || !(begun_ns..effect.end_ns(begun_ns)).contains(&now_ns)
            {
                continue;
            }
            let mut message = [0; 28];
            message[..4].copy_from_slice(&entry.number.to_le_bytes());
            message[4..8].copy_from_slice(&(topic as u32).to_le_bytes());
            message[8..12].copy_from_slice(&source.to_le_bytes());
            message[12..16].copy_from_slice(&incarnation.to_le_bytes());
            message[16..24].copy_from_slice(&sequence.to_le_bytes());
            let random = xxh3_64_with_seed(&message, self.seed);
            let activation = Activation { number: entry.number, random };
            if random::unit(activation.draw(0)) < extent.probability.value() {
                each(fault, &activation);
                entry.messages += 1;
            }
        }
    }

    /// Notes that a message which fault `number` had corrupted passed a receiver's check.
    pub(crate) fn went_undetected(&self, number: u32) {
        let mut entries = self.entries.borrow_mut();
        for entry in entries.iter_mut().filter(|entry| entry.number == number) {
            entry.undetected += 1;
        }
    }

    /// True if one may replace messages of `source` on `topic` by an earlier one.
    pub(crate) fn may_freeze(&self, topic: Topic, source: u32) -> bool {
        let freezes = |effect: &Effect| {
            let fault = effect.of_senders();
            fault.is_some_and(|fault| matches!(fault.falsification, Falsification::Freeze { .. }))
        };
        topic.role() != Role::Truth
            && self.entries.borrow().iter().any(|Entry { fault, .. }| {
                freezes(&fault.effect) && is_aimed(&fault.effect, topic, source)
            })
    }

    /// Adds the effects of all faults so far.
    pub(crate) fn statistics(&self, into: &mut Vec<FaultStatistics>) {
        into.extend(self.entries.borrow().iter().filter(|entry| entry.messages > 0).filter_map(
            |&Entry { number: fault, begun_ns, messages, undetected, .. }| {
                begun_ns.map(|begun_ns| FaultStatistics { fault, begun_ns, messages, undetected })
            },
        ));
    }
}

/// State of the drive in a message of the ego's ground truth: what faults can wait for.
pub(super) fn drive<T: Message>(message: &T) -> Option<&EgoTruth> {
    (T::TOPIC == Topic::EgoTruth).then(|| bytemuck::from_bytes(bytemuck::bytes_of(message)))
}

/// True if the fault is one of messages of `source` on `topic`.
fn is_aimed(effect: &Effect, topic: Topic, source: u32) -> bool {
    match effect.target() {
        Target::Topic(disturbed) => disturbed == topic,
        Target::Service(service) => service.to_wire() == source,
        Target::Helper(_) | Target::Machine => false,
    }
}

/// The services that a fault concerns; the launcher need not inform the others.
pub fn concerned(fault: &Fault) -> Vec<Service> {
    match fault.effect.target() {
        Target::Topic(topic) if fault.effect.of_channels().is_some() => topic.consumers().to_vec(),
        Target::Topic(topic) => topic.sources().to_vec(),
        Target::Service(service) => vec![service],
        Target::Helper(_) | Target::Machine => Vec::new(),
    }
}
