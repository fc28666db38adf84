//! Topics in the memory of one process, whose only thread all members of the run share.
//!
//! Each receiver of a topic has a queue; a sender puts a copy of its message into every one of them.
//! A sender whose receiver lags waits for its next turn, as it would wait for room in shared memory.

use super::ends::{Connect, Input, Receiver, Sender, SenderId, buffer, buffer_of};
use crate::Timetable;
use crate::coroutine::Pause;
use crate::link::End;
use crate::waking::Waiter;
use messages::{Message, Topic};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

/// Room that a queue has from the start, bytes; few fall back by more than a slow service's period.
const ROOM_BYTES: usize = 16 << 10;

/// The topics of a run.
#[derive(Debug)]
pub struct Bus {
    topics: RefCell<Vec<(Topic, Rc<dyn Any>)>>,
    /// Messages that may wait in a queue, unless they are large.
    limit: usize,
    ports: Cell<u64>,
    /// Messages put into queues and taken out of them so far.
    moved: Rc<Cell<u64>>,
    /// No member can go on: all wait for messages that no member will send.
    stalled: Rc<Cell<bool>>,
}

impl Bus {
    pub(crate) fn new(timetable: &Timetable) -> Self {
        Self {
            topics: RefCell::default(),
            limit: buffer(timetable),
            ports: Cell::new(0),
            moved: Rc::default(),
            stalled: Rc::default(),
        }
    }

    /// Messages put into queues and taken out of them so far.
    pub(crate) fn moved(&self) -> u64 {
        self.moved.get()
    }

    /// Ends all waits: no message will come.
    pub(crate) fn stall(&self) {
        self.stalled.set(true);
    }

    fn queues<T: Message>(&self) -> Rc<Queues<T>> {
        let mut topics = self.topics.borrow_mut();
        if let Some((_, queues)) = topics.iter().find(|(topic, _)| *topic == T::TOPIC) {
            return Rc::clone(queues).downcast().expect("a topic has one message type");
        }
        let queues = Rc::new(Queues::<T>(RefCell::default()));
        topics.push((T::TOPIC, Rc::clone(&queues) as Rc<dyn Any>));
        queues
    }
}

/// The queues of a topic; one is gone when its receiver is.
#[derive(Debug)]
struct Queues<T>(RefCell<Vec<Weak<Queue<T>>>>);

type Queue<T> = RefCell<VecDeque<(T, SenderId)>>;

/// A member's place at the bus.
#[derive(Clone, Debug)]
pub struct Seat {
    bus: Rc<Bus>,
    /// The member's number, which stands for its process id.
    member: u32,
    /// None for observers, which never wait.
    pause: Option<Pause>,
}

impl Seat {
    pub(crate) fn new(bus: Rc<Bus>, member: u32, pause: Option<Pause>) -> Self {
        Self { bus, member, pause }
    }

    pub(super) fn publisher<T: Message>(&self, end: End) -> Rc<dyn Sender<T>> {
        let number = self.bus.ports.get() + 1;
        self.bus.ports.set(number);
        Rc::new(MemorySender {
            queues: self.bus.queues::<T>(),
            id: SenderId::in_process(self.member, number),
            limit: buffer_of(T::TOPIC, self.bus.limit),
            moved: Rc::clone(&self.bus.moved),
            stalled: Rc::clone(&self.bus.stalled),
            pause: self.pause.clone(),
            end,
        })
    }

    pub(super) fn subscriber<T: Message>(&self) -> Rc<dyn Receiver<T>> {
        let room = (ROOM_BYTES / size_of::<T>()).min(self.bus.limit);
        let queue = Rc::new(Queue::<T>::new(VecDeque::with_capacity(room)));
        self.bus.queues::<T>().0.borrow_mut().push(Rc::downgrade(&queue));
        Rc::new(MemoryReceiver { queue, moved: Rc::clone(&self.bus.moved) })
    }

    pub(super) fn waiter(&self) -> Waiter {
        let pause = self.pause.clone().expect("observers do not wait");
        Waiter::InProcess { pause, stalled: Rc::clone(&self.bus.stalled) }
    }
}

#[derive(Debug)]
struct MemorySender<T> {
    queues: Rc<Queues<T>>,
    id: SenderId,
    limit: usize,
    moved: Rc<Cell<u64>>,
    stalled: Rc<Cell<bool>>,
    pause: Option<Pause>,
    end: End,
}

impl<T: Message> MemorySender<T> {
    /// Puts `message` into `queue`, waiting for room.
    fn put(&self, queue: &Queue<T>, message: &T) -> Result<(), String> {
        while queue.borrow().len() >= self.limit {
            if self.end.is_now() {
                return Ok(());
            }
            if self.stalled.get() {
                return Err("a receiver does not read".into());
            }
            match &self.pause {
                Some(pause) => pause.wait(),
                None => return Err("a receiver's queue is full".into()),
            }
        }
        queue.borrow_mut().push_back((*message, self.id));
        self.moved.set(self.moved.get() + 1);
        Ok(())
    }
}

impl<T: Message> Connect for MemorySender<T> {
    fn connect(&self) -> Result<(), String> {
        Ok(())
    }
}

impl<T: Message> Sender<T> for MemorySender<T> {
    fn send(&self, message: &T) -> Result<(), String> {
        // One look at a time: others may have their turn in between.
        let mut index = 0;
        loop {
            let next = self.queues.0.borrow().get(index).map(Weak::upgrade);
            match next {
                Some(Some(queue)) => self.put(&queue, message)?,
                Some(None) => {}
                None => return Ok(()),
            }
            index += 1;
        }
    }
}

#[derive(Debug)]
struct MemoryReceiver<T> {
    queue: Rc<Queue<T>>,
    moved: Rc<Cell<u64>>,
}

impl<T: Message> Connect for MemoryReceiver<T> {
    fn connect(&self) -> Result<(), String> {
        Ok(())
    }
}

impl<T: Message> Input for MemoryReceiver<T> {
    fn has_input(&self) -> bool {
        !self.queue.borrow().is_empty()
    }
}

impl<T: Message> Receiver<T> for MemoryReceiver<T> {
    fn receive(&self) -> Result<Option<(T, SenderId)>, String> {
        let message = self.queue.borrow_mut().pop_front();
        self.moved.set(self.moved.get() + u64::from(message.is_some()));
        Ok(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{Command, Odometry};

    fn bus() -> Rc<Bus> {
        let strides = [1, 5, 10, 10, 5];
        Rc::new(Bus::new(&Timetable { step_ns: 10_000_000, strides, last_step: 100 }))
    }

    fn odometry(sequence: u64) -> Odometry {
        let mut message = Odometry::zeroed();
        message.header.sequence = sequence;
        message
    }

    #[test]
    fn every_receiver_gets_every_message_in_order_and_knows_who_sent_it() {
        let bus = bus();
        let (plant, other) = (Seat::new(Rc::clone(&bus), 1, None), Seat::new(bus, 4, None));
        let sender = plant.publisher::<Odometry>(End::default());
        let (one, two) = (other.subscriber::<Odometry>(), plant.subscriber::<Odometry>());
        let commands = other.subscriber::<Command>();
        sender.send(&odometry(1)).expect("room");
        sender.send(&odometry(2)).expect("room");
        for receiver in [one, two] {
            for sequence in 1..=2 {
                let (message, from) = receiver.receive().expect("memory").expect("a message");
                assert_eq!((message.header.sequence, from.pid()), (sequence, 1));
            }
            assert!(!receiver.has_input());
        }
        assert!(!commands.has_input());
    }

    #[test]
    fn a_receiver_that_is_gone_holds_no_sender_up() {
        let seat = Seat::new(bus(), 1, None);
        let sender = seat.publisher::<Odometry>(End::default());
        let receiver = seat.subscriber::<Odometry>();
        let full = (1..).find(|&k| sender.send(&odometry(k)).is_err());
        assert_eq!(full, Some(51), "as many as in shared memory");
        drop(receiver);
        sender.send(&odometry(52)).expect("no receiver is left");
    }
}
