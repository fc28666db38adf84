//! The process that may send for a service: one word in shared memory, its epoch.
//!
//! The word holds the incarnation of the one process of a service whose messages count. A standby takes the
//! service over by a compare-and-swap from the present epoch to its own, a later one:
//!
//! ```text
//! sender:    word == own incarnation ─► send          else: it was replaced, and leaves
//! standby:   compare-and-swap (active's ─► own)        fails if another process was faster
//! consumer:  word == message's incarnation ─► use      else: of a process that was replaced
//! ```
//!
//! The sender's look alone is not enough. A process can be stopped between the look and the message, and continue after
//! it was replaced. The consumer's look comes after the message has arrived. So after the compare-and-swap, consumers
//! use no message of an earlier epoch. At no instant are two senders accepted. The tests at the end check that over all
//! interleavings (feature `loom`). The [`Gate`] of a process looks for its ports, and keeps a standby silent.

use crate::Group;
use crate::words::{RunWords, Shared};
use messages::Service;
use std::cell::Cell;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// An atomic word: the machine's, or a model checker's.
pub trait Word {
    /// Reads it, and sees all that was written before the value that it finds.
    fn load(&self) -> u32;

    /// Puts `new` into it if it holds `present`.
    fn swap_from(&self, present: u32, new: u32) -> bool;
}

impl Word for AtomicU32 {
    fn load(&self) -> u32 {
        self.load(Ordering::Acquire)
    }

    fn swap_from(&self, present: u32, new: u32) -> bool {
        self.compare_exchange(present, new, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }
}

/// True if the process of this epoch has its place in the group: it may send, and its messages are used.
pub fn is_present(word: &impl Word, epoch: u32) -> bool {
    word.load() == epoch
}

/// Takes the service over from the process of epoch `active`; false if it is not the active one any more.
pub fn take_over(word: &impl Word, active: u32, own: u32) -> bool {
    active < own && word.swap_from(active, own)
}

/// Makes `own` the epoch of a process that is started where no other one lives. False if a later one has it already.
pub fn claim(word: &impl Word, own: u32) -> bool {
    let present = word.load();
    present == own || take_over(word, present, own)
}

/// The other processes of the run, as a port sees them: its members, and the epochs of the services with a standby.
#[derive(Clone, Debug)]
pub(crate) struct Peers {
    pub(crate) words: Arc<Shared<RunWords>>,
    fenced: [bool; Service::ALL.len()],
}

impl Peers {
    pub(crate) fn of(group: &Group) -> io::Result<Self> {
        let fenced = Service::ALL.map(|service| group.standby.contains(&service));
        Ok(Self { words: Arc::new(RunWords::map(&group.prefix)?), fenced })
    }

    /// The epoch of a service; `None` where it has no standby.
    pub(crate) fn epoch(&self, service: Service) -> Option<&AtomicU32> {
        self.fenced[service.index()].then(|| &self.words.of(service).epoch)
    }

    /// True if a message of incarnation `incarnation` of the service with this number may be used.
    pub(crate) fn accept(&self, source: u32, incarnation: u32) -> bool {
        let word = Service::by_number(source).and_then(|service| self.epoch(service));
        word.is_none_or(|word| is_present(word, incarnation))
    }
}

/// Decision on a message that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    Open,
    /// It is kept, since the process is a standby.
    Held,
    /// It is dropped, since the process was replaced.
    Shut,
}

/// The gate of one process, shared by its ports.
#[derive(Debug)]
pub(crate) struct Gate {
    peers: Option<Peers>,
    service: Service,
    incarnation: u32,
    is_standby: Cell<bool>,
}

impl Gate {
    pub(crate) fn of(peers: Option<Peers>, service: Service, incarnation: u32) -> Self {
        Self { peers, service, incarnation, is_standby: Cell::new(false) }
    }

    /// Makes the process a standby, or ends that.
    pub(crate) fn set_standby(&self, is_standby: bool) {
        self.is_standby.set(is_standby);
    }

    pub(crate) fn is_standby(&self) -> bool {
        self.is_standby.get()
    }

    /// The service's epoch; `None` where it has no standby.
    fn word(&self) -> Option<&AtomicU32> {
        self.peers.as_ref().and_then(|peers| peers.epoch(self.service))
    }

    /// Makes this process the active one, if it replaces one that is gone; false if
    /// another process is it.
    pub(crate) fn claim(&self) -> bool {
        self.word().is_none_or(|word| claim(word, self.incarnation))
    }

    /// Decision on a message that is sent now.
    pub(crate) fn passage(&self) -> Passage {
        if self.is_standby() {
            return Passage::Held;
        }
        match self.word() {
            Some(word) if !is_present(word, self.incarnation) => Passage::Shut,
            _ => Passage::Open,
        }
    }
}

/// The epochs over all interleavings of their processes.
#[cfg(all(test, feature = "loom"))]
mod interleavings {
    use super::*;
    use loom::sync::atomic::AtomicU32 as ModelWord;
    use loom::sync::{Arc, Mutex};
    use loom::thread;

    impl Word for ModelWord {
        fn load(&self) -> u32 {
            self.load(Ordering::Acquire)
        }

        fn swap_from(&self, present: u32, new: u32) -> bool {
            self.compare_exchange(present, new, Ordering::AcqRel, Ordering::Acquire).is_ok()
        }
    }

    /// The word, and the messages on their way: the epochs of their senders.
    #[derive(Default)]
    struct World {
        word: ModelWord,
        on_their_way: Mutex<Vec<u32>>,
    }

    /// Sends as long as it may; it can be stopped for any time between the look and the message.
    fn send(world: &World, own: u32, messages: u32) {
        for _ in 0..messages {
            if !is_present(&world.word, own) {
                return;
            }
            world.on_their_way.lock().expect("no panic").push(own);
        }
    }

    /// Takes the messages that have come, some of which may be used.
    fn receive(world: &World, used: &mut Vec<u32>) {
        let come = std::mem::take(&mut *world.on_their_way.lock().expect("no panic"));
        used.extend(come.into_iter().filter(|&sender| is_present(&world.word, sender)));
    }

    #[test]
    fn no_consumer_uses_a_replaced_process_again_whatever_the_interleaving() {
        loom::model(|| {
            let world = Arc::new(World::default());
            let (of_old, of_standby) = (Arc::clone(&world), Arc::clone(&world));
            // It is stopped and continued at any instant, and has no sign that it was replaced.
            let old = thread::spawn(move || send(&of_old, 0, 2));
            let standby = thread::spawn(move || {
                assert!(take_over(&of_standby.word, 0, 1), "it is the only one");
                send(&of_standby, 1, 1);
            });
            let mut used = Vec::new();
            for _ in 0..2 {
                receive(&world, &mut used);
            }
            old.join().expect("no panic");
            standby.join().expect("no panic");
            let before = used.len();
            receive(&world, &mut used);
            assert!(used.is_sorted(), "{used:?}");
            assert!(used[before..].iter().all(|&sender| sender == 1), "{used:?}");
        });
    }

    #[test]
    fn one_of_two_that_take_over_succeeds_and_the_other_sends_nothing() {
        loom::model(|| {
            let world = Arc::new(World::default());
            let candidates = [1, 2].map(|own| {
                let world = Arc::clone(&world);
                thread::spawn(move || {
                    let took = take_over(&world.word, 0, own);
                    if took {
                        send(&world, own, 1);
                    }
                    took
                })
            });
            let took = candidates.map(|candidate| candidate.join().expect("no panic"));
            assert_eq!(took.iter().filter(|took| **took).count(), 1);
            let mut used = Vec::new();
            receive(&world, &mut used);
            assert_eq!(used.len(), 1);
            assert_eq!(used[0], if took[0] { 1 } else { 2 });
        });
    }

    #[test]
    fn a_process_that_is_started_cold_and_a_late_standby_do_not_both_speak() {
        loom::model(|| {
            let world = Arc::new(World::default());
            let (of_standby, of_cold) = (Arc::clone(&world), Arc::clone(&world));
            let standby = thread::spawn(move || {
                if take_over(&of_standby.word, 0, 1) {
                    send(&of_standby, 1, 1);
                }
            });
            let cold = thread::spawn(move || {
                if claim(&of_cold.word, 2) {
                    send(&of_cold, 2, 1);
                }
            });
            let mut used = Vec::new();
            receive(&world, &mut used);
            standby.join().expect("no panic");
            cold.join().expect("no panic");
            receive(&world, &mut used);
            assert!(used.is_sorted(), "{used:?}");
        });
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{Mode, Timetable};

    /// A run with standbys, whose page is removed with it.
    pub(in crate::survival) struct Run(pub(in crate::survival) Group);

    impl Run {
        pub(in crate::survival) fn new(name: &str, standby: &[Service]) -> Self {
            Self(Group {
                root: "/tmp".into(),
                prefix: format!("timegap_fence-{name}-{}_", std::process::id()),
                mode: Mode::Realtime,
                standby: standby.to_vec(),
                timetable: Timetable { step_ns: 1, strides: [1; Service::ALL.len()], last_step: 1 },
                patience_ns: 1,
                scenario: String::new(),
            })
        }

        pub(in crate::survival) fn peers(&self) -> Peers {
            Peers::of(&self.0).expect("shared memory")
        }
    }

    impl Drop for Run {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(format!("/dev/shm/{}wake", self.0.prefix));
        }
    }

    #[test]
    fn messages_of_services_with_a_standby_alone_are_compared_with_the_epoch() {
        let run = Run::new("two", &[Service::Controller, Service::Obu]);
        let peers = run.peers();
        for service in Service::ALL {
            let fenced = matches!(service, Service::Controller | Service::Obu);
            assert_eq!(peers.epoch(service).is_some(), fenced, "{service}");
            let source = service.to_wire();
            assert!(peers.accept(source, 0), "{service}: epoch 0 speaks at first");
            assert_eq!(peers.accept(source, 7), !fenced, "{service}");
        }
        // Both maps of the page are the same words, and each service has its own.
        let other = run.peers();
        assert!(take_over(other.epoch(Service::Obu).expect("fenced"), 0, 7));
        let accepts = |service: Service, own| peers.accept(service.to_wire(), own);
        assert!(accepts(Service::Obu, 7) && !accepts(Service::Obu, 0));
        assert!(accepts(Service::Controller, 0) && !accepts(Service::Controller, 7));
        assert!(peers.accept(0, 9) && peers.accept(99, 9), "no service has the number");
    }

    #[test]
    fn an_epoch_never_goes_back() {
        let word = AtomicU32::new(0);
        assert!(take_over(&word, 0, 3) && !take_over(&word, 0, 4) && !take_over(&word, 3, 3));
        assert!(!claim(&word, 2) && claim(&word, 3) && claim(&word, 4));
        assert!(!is_present(&word, 3) && is_present(&word, 4));
    }

    #[test]
    fn without_a_standby_of_its_service_a_gate_is_open_until_it_stands_by() {
        let run = Run::new("open", &[Service::PerceptionSim]);
        let of_another = Gate::of(Some(run.peers()), Service::Plant, 3);
        for gate in [Gate::of(None, Service::Plant, 0), of_another] {
            assert!(gate.claim() && !gate.is_standby());
            assert_eq!(gate.passage(), Passage::Open);
            gate.set_standby(true);
            assert!(gate.is_standby());
            assert_eq!(gate.passage(), Passage::Held);
            gate.set_standby(false);
            assert_eq!(gate.passage(), Passage::Open);
        }
    }

    #[test]
    fn a_standby_holds_its_messages_and_a_replaced_process_sends_nothing() {
        let service = Service::Controller;
        let run = Run::new("replaced", &[service]);
        let [active, standby] = [0, 1].map(|own| Gate::of(Some(run.peers()), service, own));
        assert!(active.claim());
        standby.set_standby(true);
        assert_eq!((active.passage(), standby.passage()), (Passage::Open, Passage::Held));
        let peers = run.peers();
        let word = peers.epoch(service).expect("it has a standby");
        assert!(take_over(word, 0, 1));
        // The standby is silent until its loop ends the time as a standby.
        assert_eq!((active.passage(), standby.passage()), (Passage::Shut, Passage::Held));
        standby.set_standby(false);
        assert_eq!((active.passage(), standby.passage()), (Passage::Shut, Passage::Open));
        assert!(!active.claim() && standby.claim());
    }

    #[test]
    fn a_process_that_is_started_cold_claims_a_later_epoch_alone() {
        let service = Service::Aebs;
        let run = Run::new("cold", &[service]);
        let gate = |own| Gate::of(Some(run.peers()), service, own);
        assert_eq!(gate(4).passage(), Passage::Shut, "not claimed");
        assert!(gate(4).claim() && gate(4).claim() && !gate(3).claim());
        assert_eq!((gate(3).passage(), gate(4).passage()), (Passage::Shut, Passage::Open));
    }
}
