//! Topics in the memory of one process, whose only thread all members of the run share.
//!
//! A topic is its newest message and the count of all. A service looks at it when it is released. A service that is
//! released less often than the topic's sender looks once, and counts what came in between. Readers that need each
//! message have a queue: observers, and readers of a topic that a fault of messages acts on.
//!
//! A sender goes on only if each reader sees what was the newest message at its release: it waits for its next turn, as
//! it would wait for room in shared memory. It writes the next message into one that its readers no longer have.

use super::{Sealing, Wanted, buffer, buffer_of};
use crate::in_process::coroutine::Pause;
use crate::life::link::End;
use crate::transport::waking::Waiter;
use crate::{Clock, Timetable, TransportError};
use messages::{Message, Topic};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

/// The topics of a run.
#[derive(Debug)]
pub(crate) struct Bus {
    topics: RefCell<Vec<(Topic, Rc<dyn Any>)>>,
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

    fn slot<T: Message>(&self) -> Rc<Slot<T>> {
        let mut topics = self.topics.borrow_mut();
        if let Some((_, slot)) = topics.iter().find(|(topic, _)| *topic == T::TOPIC) {
            return Rc::clone(slot).downcast().expect("a topic has one message type");
        }
        let slot = Rc::new(Slot::<T>::default());
        topics.push((T::TOPIC, Rc::clone(&slot) as Rc<dyn Any>));
        slot
    }
}

#[derive(Debug)]
struct Slot<T> {
    newest: RefCell<Option<Rc<T>>>,
    /// Messages sent so far.
    sent: Cell<u64>,
    /// Clocks of the services that look at it; one is gone when its service is.
    clocks: RefCell<Vec<Weak<Clock>>>,
    queues: RefCell<Vec<Weak<Queue<T>>>>,
}

type Queue<T> = RefCell<VecDeque<Rc<T>>>;

impl<T> Default for Slot<T> {
    fn default() -> Self {
        let (newest, sent, clocks, queues) = Default::default();
        Self { newest, sent, clocks, queues }
    }
}

impl<T> Slot<T> {
    /// True if a message of `step` hides none that a reader needs, and no queue has `limit` messages.
    fn has_room(&self, step: u64, limit: usize) -> bool {
        let reaches = |clock: &Weak<Clock>| clock.upgrade().is_none_or(|c| c.step() >= step);
        let has_room = |queue: &Weak<Queue<T>>| {
            queue.upgrade().is_none_or(|queue| queue.borrow().len() < limit)
        };
        self.clocks.borrow().iter().all(reaches) && self.queues.borrow().iter().all(has_room)
    }

    fn put(&self, message: &Rc<T>) {
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

    pub(super) fn sender<T: Message>(&self, end: End) -> MemorySender<T> {
        MemorySender {
            slot: self.bus.slot(),
            pool: RefCell::default(),
            limit: buffer_of(T::TOPIC, self.bus.limit),
            seat: self.clone(),
            end,
        }
    }

    pub(super) fn receiver<T: Message>(&self, wanted: Wanted<'_>) -> MemoryReceiver<T> {
        let (slot, moved) = (self.bus.slot::<T>(), Rc::clone(&self.bus.moved));
        let source = match wanted {
            Wanted::Every => {
                let queue = Rc::<Queue<T>>::default();
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
        Waiter::in_process(pause, Rc::clone(&self.bus.stalled))
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
pub(crate) struct MemorySender<T> {
    slot: Rc<Slot<T>>,
    /// Messages that were sent, oldest first: what no receiver has any more is written again.
    pool: RefCell<VecDeque<Rc<T>>>,
    /// Messages that may wait in a queue.
    limit: usize,
    seat: Seat,
    end: End,
}

impl<T: Message> MemorySender<T> {
    pub(super) fn loan(&self) -> Rc<T> {
        let mut pool = self.pool.borrow_mut();
        let unused = pool.iter().position(|message| Rc::strong_count(message) == 1);
        let message = unused.and_then(|index| pool.remove(index));
        message.unwrap_or_else(|| Rc::new(T::zeroed()))
    }

    pub(super) fn send(&self, message: Rc<T>) -> Result<(), TransportError> {
        let Seat { bus, pause } = &self.seat;
        while !self.slot.has_room(message.header().step, self.limit) {
            if self.end.is_now() {
                return Ok(());
            }
            if bus.stalled.get() {
                return Err(TransportError::NotRead);
            }
            pause.as_ref().ok_or(TransportError::Full)?.wait();
        }
        self.slot.put(&message);
        bus.moved.set(bus.moved.get() + 1);
        self.pool.borrow_mut().push_back(message);
        Ok(())
    }
}

#[derive(Debug)]
pub(crate) struct MemoryReceiver<T> {
    source: Source<T>,
    moved: Rc<Cell<u64>>,
}

#[derive(Debug)]
enum Source<T> {
    Queue(Rc<Queue<T>>),
    /// A topic, of whose messages `seen` were there at the last look.
    Slot {
        slot: Rc<Slot<T>>,
        seen: Cell<u64>,
    },
}

impl<T: Message> MemoryReceiver<T> {
    /// The next message, and how many came since the last look.
    pub(super) fn receive(&self) -> Option<(Rc<T>, u64)> {
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
    use messages::{Command, Odometry, RadarDetections};

    fn seat() -> Seat {
        let strides = [1, 5, 10, 10, 5, 10];
        let timetable = Timetable { step_ns: 10_000_000, strides, last_step: 100 };
        Seat::new(Rc::new(Bus::new(&timetable, Sealing::Sealed)), None)
    }

    fn send(sender: &MemorySender<Odometry>, step: u64) -> Result<(), TransportError> {
        let mut message = sender.loan();
        Rc::get_mut(&mut message).expect("not sent").header.step = step;
        sender.send(message)
    }

    fn steps(receiver: &MemoryReceiver<Odometry>) -> Vec<(u64, u64)> {
        let taken = std::iter::from_fn(|| receiver.receive());
        taken.map(|(message, count)| (message.header.step, count)).collect()
    }

    #[test]
    fn every_queue_gets_every_message_in_order() {
        let seat = seat();
        let sender = seat.sender::<Odometry>(End::default());
        let (one, two) = (seat.receiver(Wanted::Every), seat.receiver(Wanted::Every));
        let commands = seat.receiver::<Command>(Wanted::Every);
        send(&sender, 1).expect("room");
        send(&sender, 2).expect("room");
        for receiver in [one, two] {
            assert_eq!(steps(&receiver), [(1, 1), (2, 1)]);
        }
        assert!(commands.receive().is_none());
    }

    #[test]
    fn a_service_looks_once_at_what_came_since_its_last_release() {
        let seat = seat();
        let sender = seat.sender::<Odometry>(End::default());
        let clock = Rc::new(Clock::new(Mode::Lockstep, 10_000_000));
        let receiver = seat.receiver::<Odometry>(Wanted::Newest(&clock));
        send(&sender, 0).expect("the first release");
        assert!(matches!(send(&sender, 1), Err(TransportError::Full)), "step 0 is not looked at");
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
        let seat = seat();
        let sender = seat.sender::<Odometry>(End::default());
        let receiver = seat.receiver::<Odometry>(Wanted::Every);
        let full = (1..).find(|&k| send(&sender, k).is_err());
        assert_eq!(full, Some(51), "as many as in shared memory");
        drop(receiver);
        send(&sender, 52).expect("no receiver is left");
    }

    #[test]
    fn a_message_is_borrowed_and_not_written_again_before_its_readers_gave_it_back() {
        let seat = seat();
        let sender = seat.sender::<RadarDetections>(End::default());
        let clock = Rc::new(Clock::new(Mode::Lockstep, 10_000_000));
        let receiver = seat.receiver::<RadarDetections>(Wanted::Newest(&clock));
        let mut held: Option<Rc<RadarDetections>> = None;
        let mut addresses = Vec::new();
        for count in 1..=6 {
            let mut message = sender.loan();
            Rc::get_mut(&mut message).expect("not sent").count = count;
            addresses.push(Rc::as_ptr(&message));
            sender.send(message).expect("room");
            let before = held.as_ref().map(|held| held.count);
            assert_eq!(before, (count > 1).then(|| count - 1), "what is held stays");
            held = receiver.receive().map(|(message, _)| message);
            assert_eq!(held.as_ref().map(Rc::as_ptr), addresses.last().copied());
        }
        addresses.sort_unstable();
        addresses.dedup();
        assert_eq!(addresses.len(), 2, "written in turn");
    }
}
