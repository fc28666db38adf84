//! Topics in the memory of one process, whose only thread all members of the run share.
//!
//! A topic is its newest message and the count of all. A service looks at it when it is released. A service that is
//! released less often than the topic's sender looks once, and counts what came in between. Readers that need each
//! message have a queue: observers, and readers of a topic that a fault of messages acts on.
//!
//! A sender goes on only if each reader sees what was the newest message at its release: it waits for its next turn, as
//! it would wait for room in shared memory. It writes the next message into one that its readers no longer have.

use super::message::Words;
use super::{Sealing, Wanted, buffer, buffer_of};
use crate::in_process::coroutine::Pause;
use crate::life::link::End;
use crate::transport::waking::Waiter;
use crate::{Clock, Timetable, TransportError};
use messages::{TOPICS, Topic};
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

#[derive(Debug)]
pub(crate) struct Bus {
    topics: [Rc<Slot>; TOPICS.len()],
    /// Messages that may wait in a queue, unless they are large.
    limit: usize,
    pub(super) sealing: Sealing,
    /// Messages sent and taken so far.
    moved: Rc<Cell<u64>>,
    /// No member can go on: all wait for messages that no member will send.
    stalled: Rc<Cell<bool>>,
}

impl Bus {
    pub(crate) fn new(timetable: &Timetable, sealing: Sealing) -> Self {
        let (topics, moved, stalled) = Default::default();
        Self { topics, limit: buffer(timetable), sealing, moved, stalled }
    }

    /// Messages sent and taken so far.
    pub(crate) fn moved(&self) -> u64 {
        self.moved.get()
    }

    /// Ends all waits: no message will come.
    pub(crate) fn stall(&self) {
        self.stalled.set(true);
    }

    fn slot(&self, topic: Topic) -> Rc<Slot> {
        Rc::clone(&self.topics[topic as usize])
    }
}

#[derive(Debug, Default)]
struct Slot {
    newest: RefCell<Option<Words>>,
    /// Messages sent so far.
    sent: Cell<u64>,
    /// Clocks of the services that look at it; one is gone when its service is.
    clocks: RefCell<Vec<Weak<Clock>>>,
    queues: RefCell<Vec<Weak<Queue>>>,
}

type Queue = RefCell<VecDeque<Words>>;

impl Slot {
    /// True if a message of `step` hides none that a reader needs, and no queue has `limit` messages.
    fn has_room(&self, step: u64, limit: usize) -> bool {
        let reaches = |clock: &Weak<Clock>| clock.upgrade().is_none_or(|c| c.step() >= step);
        let has_room =
            |queue: &Weak<Queue>| queue.upgrade().is_none_or(|queue| queue.borrow().len() < limit);
        self.clocks.borrow().iter().all(reaches) && self.queues.borrow().iter().all(has_room)
    }

    fn put(&self, message: &Words) {
        for queue in self.queues.borrow().iter().filter_map(Weak::upgrade) {
            queue.borrow_mut().push_back(Rc::clone(message));
        }
        self.newest.replace(Some(Rc::clone(message)));
        self.sent.set(self.sent.get() + 1);
    }
}

/// A member's place at the bus.
#[derive(Clone, Debug)]
pub(crate) struct Seat {
    pub(super) bus: Rc<Bus>,
    /// `None` for observers, which never wait.
    pause: Option<Pause>,
}

impl Seat {
    pub(crate) fn new(bus: Rc<Bus>, pause: Option<Pause>) -> Self {
        Self { bus, pause }
    }

    pub(super) fn sender(&self, topic: Topic, end: End) -> MemorySender {
        let (slot, limit) = (self.bus.slot(topic), buffer_of(topic, self.bus.limit));
        let words = topic.message_bytes() / size_of::<u64>();
        MemorySender { slot, pool: RefCell::default(), words, limit, seat: self.clone(), end }
    }

    pub(super) fn receiver(&self, topic: Topic, wanted: Wanted<'_>) -> MemoryReceiver {
        let (slot, moved) = (self.bus.slot(topic), Rc::clone(&self.bus.moved));
        let source = match wanted {
            Wanted::Every => {
                let queue = Rc::<Queue>::default();
                slot.queues.borrow_mut().push(Rc::downgrade(&queue));
                Source::Queue(queue)
            }
            Wanted::Newest(clock) => {
                slot.clocks.borrow_mut().push(Rc::downgrade(clock));
                let seen = Cell::new(slot.sent.get());
                Source::Slot { slot, seen }
            }
        };
        MemoryReceiver { source, moved }
    }

    /// The means by which this member's code waits for the caller of the run; `None` for observers.
    pub(crate) fn turns(&self) -> Option<Turns> {
        Some(Turns { pause: self.pause.clone()?, moved: Rc::clone(&self.bus.moved) })
    }

    pub(super) fn waiter(&self) -> Waiter {
        let pause = self.pause.clone().expect("observers do not wait");
        Waiter::InProcess { pause, stalled: Rc::clone(&self.bus.stalled) }
    }
}

/// The turns of one service in a run in one process.
///
/// Code of a service may need something from the run's caller. It leaves a note for the caller and waits for a turn.
/// The caller looks between two calls of [`InProcess::take_turns`](crate::InProcess::take_turns).
#[derive(Clone, Debug)]
pub struct Turns {
    pause: Pause,
    moved: Rc<Cell<u64>>,
}

impl Turns {
    /// Lets the other services and the caller of the run go on, until the next turn.
    ///
    /// # Panics
    /// If the service whose turns these are does not run.
    pub fn wait(&self) {
        // The caller answers between the rounds: the round is not a standstill.
        self.moved.set(self.moved.get() + 1);
        self.pause.wait();
    }
}

#[derive(Debug)]
pub(crate) struct MemorySender {
    slot: Rc<Slot>,
    /// Messages that were sent: what no receiver has any more is written again.
    pool: RefCell<Vec<Words>>,
    words: usize,
    limit: usize,
    seat: Seat,
    end: End,
}

impl MemorySender {
    pub(super) fn loan(&self) -> Words {
        let mut pool = self.pool.borrow_mut();
        match pool.iter().position(|message| Rc::strong_count(message) == 1) {
            Some(unused) => pool.swap_remove(unused),
            None => vec![0; self.words].into(),
        }
    }

    pub(super) fn send(&self, message: Words, step: u64) -> Result<(), TransportError> {
        let Seat { bus, pause } = &self.seat;
        while !self.slot.has_room(step, self.limit) {
            if self.end.is_now() {
                return Ok(());
            }
            if bus.stalled.get() {
                return Err(TransportError::Refused("a receiver does not read"));
            }
            let full = || TransportError::Refused("a receiver's queue is full");
            pause.as_ref().ok_or_else(full)?.wait();
        }
        self.slot.put(&message);
        bus.moved.set(bus.moved.get() + 1);
        self.pool.borrow_mut().push(message);
        Ok(())
    }
}

#[derive(Debug)]
pub(crate) struct MemoryReceiver {
    source: Source,
    moved: Rc<Cell<u64>>,
}

#[derive(Debug)]
enum Source {
    Queue(Rc<Queue>),
    /// A topic, of whose messages `seen` were there at the last look.
    Slot {
        slot: Rc<Slot>,
        seen: Cell<u64>,
    },
}

impl MemoryReceiver {
    /// The next message, and how many came since the last look.
    pub(super) fn receive(&self) -> Option<(Words, u64)> {
        let taken = match &self.source {
            Source::Queue(queue) => (queue.borrow_mut().pop_front()?, 1),
            Source::Slot { slot, seen } => {
                let sent = slot.sent.get();
                let messages = sent - seen.replace(sent);
                if messages == 0 {
                    return None;
                }
                (slot.newest.borrow().clone()?, messages)
            }
        };
        self.moved.set(self.moved.get() + 1);
        Some(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mode;
    use crate::transport::{Held, Loan, Receiver, Sender, Transport};
    use messages::{Message, Odometry, RadarDetections};

    const ODOMETRY: Topic = Topic::Odometry;

    fn run() -> Transport {
        let strides = [1, 5, 10, 10, 5, 10];
        let timetable = Timetable { step_ns: 10_000_000, strides, last_step: 100 };
        Transport::Memory(Seat::new(Rc::new(Bus::new(&timetable, Sealing::Sealed)), None))
    }

    fn sender(run: &Transport, topic: Topic) -> Rc<Sender> {
        run.sender(topic, End::default()).expect("there is memory")
    }

    fn receiver(run: &Transport, topic: Topic, wanted: Wanted<'_>) -> Rc<Receiver> {
        run.receiver(topic, wanted).expect("there is memory")
    }

    fn send(sender: &Sender, step: u64) -> Result<(), TransportError> {
        let mut message = Loan::<Odometry>::at(sender.loan().expect("there is memory"));
        message.header.step = step;
        sender.send(message.0, step)
    }

    /// The next message, and how many came since the last look.
    fn receive<T: Message>(receiver: &Receiver, held: &mut Held<T>) -> Option<u64> {
        let (message, arrival) = receiver.receive().expect("memory does not fail")?;
        held.take(message);
        Some(arrival.messages)
    }

    fn steps(receiver: &Receiver) -> Vec<(u64, u64)> {
        let mut held = receiver.room::<Odometry>();
        let mut taken = Vec::new();
        while let Some(count) = receive(receiver, &mut held) {
            taken.push((held.get().expect("it is there").header.step, count));
        }
        taken
    }

    #[test]
    fn every_queue_gets_every_message_in_order() {
        let run = run();
        let sender = sender(&run, ODOMETRY);
        let [one, two] = [(); 2].map(|()| receiver(&run, ODOMETRY, Wanted::Every));
        let commands = receiver(&run, Topic::Command, Wanted::Every);
        send(&sender, 1).expect("room");
        send(&sender, 2).expect("room");
        for receiver in [one, two] {
            assert_eq!(steps(&receiver), [(1, 1), (2, 1)]);
        }
        assert_eq!(receive(&commands, &mut commands.room::<messages::Command>()), None);
    }

    #[test]
    fn a_service_looks_once_at_what_came_since_its_last_release() {
        let run = run();
        let sender = sender(&run, ODOMETRY);
        let clock = Rc::new(Clock::new(Mode::Lockstep, 10_000_000));
        let receiver = receiver(&run, ODOMETRY, Wanted::Newest(&clock));
        send(&sender, 0).expect("the first release");
        let full = send(&sender, 1).expect_err("step 0 is not looked at");
        assert!(full.to_string().contains("full"), "{full}");
        assert_eq!(steps(&receiver), [(0, 1)]);
        clock.set_step(5);
        (1..=5).for_each(|step| send(&sender, step).expect("up to the next release"));
        assert!(send(&sender, 6).is_err(), "it would hide the message of the release");
        assert_eq!(steps(&receiver), [(5, 5)]);
        drop(clock);
        send(&sender, 6).expect("the service is gone");
        assert_eq!(steps(&receiver), [(6, 1)]);
    }

    #[test]
    fn a_receiver_that_is_gone_holds_no_sender_up() {
        let run = run();
        let sender = sender(&run, ODOMETRY);
        let receiver = receiver(&run, ODOMETRY, Wanted::Every);
        let full = (1..).find(|&k| send(&sender, k).is_err());
        assert_eq!(full, Some(51), "as many as in shared memory");
        drop(receiver);
        send(&sender, 52).expect("no receiver is left");
    }

    #[test]
    fn a_message_is_borrowed_and_not_written_again_before_its_readers_gave_it_back() {
        let run = run();
        let sender = sender(&run, Topic::RadarDetections);
        let clock = Rc::new(Clock::new(Mode::Lockstep, 10_000_000));
        let receiver = receiver(&run, Topic::RadarDetections, Wanted::Newest(&clock));
        let mut held = receiver.room::<RadarDetections>();
        let mut addresses = Vec::new();
        for count in 1..=6 {
            let mut message = Loan::<RadarDetections>::at(sender.loan().expect("there is memory"));
            message.count = count;
            addresses.push(std::ptr::from_ref(&*message));
            sender.send(message.0, 0).expect("room");
            let before = held.get().map(|held| held.count);
            assert_eq!(before, (count > 1).then(|| count - 1), "what is held stays");
            assert_eq!(receive(&receiver, &mut held), Some(1));
            assert_eq!(held.get().map(std::ptr::from_ref), addresses.last().copied());
        }
        addresses.sort_unstable();
        addresses.dedup();
        assert_eq!(addresses.len(), 2, "written in turn");
    }
}
