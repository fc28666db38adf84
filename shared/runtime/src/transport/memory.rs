//! Topics in the memory of one process, whose only thread all members of the run share.
//!
//! Each receiver of a topic has a queue. A sender puts a handle of its message into every one of them. It writes the
//! next message into one that receivers no longer have. A sender whose receiver lags waits for its next turn, as it
//! would wait for room in shared memory.

use super::ends::{
    Arrival, Connect, Input, Receiver, Sealing, Sender, SenderId, buffer, buffer_of,
};
use super::error::TransportError;
use super::held::Held;
use super::loan::{Loan, Place};
use crate::Timetable;
use crate::in_process::coroutine::Pause;
use crate::life::link::End;
use crate::transport::waking::Waiter;
use messages::{Message, Topic};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

/// Messages for which a queue has room from the start; few fall back by more than a slow service's period.
const ROOM: usize = 32;

/// The topics of a run.
#[derive(Debug)]
pub struct Bus {
    topics: RefCell<Vec<(Topic, Rc<dyn Any>)>>,
    /// Messages that may wait in a queue, unless they are large.
    limit: usize,
    sealing: Sealing,
    ports: Cell<u64>,
    /// Messages put into queues and taken out of them so far.
    moved: Rc<Cell<u64>>,
    /// No member can go on: all wait for messages that no member will send.
    stalled: Rc<Cell<bool>>,
}

impl Bus {
    pub(crate) fn new(timetable: &Timetable, sealing: Sealing) -> Self {
        Self {
            topics: RefCell::default(),
            limit: buffer(timetable),
            sealing,
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

type Queue<T> = RefCell<VecDeque<(Rc<T>, SenderId)>>;

/// A member's place at the bus.
#[derive(Clone, Debug)]
pub struct Seat {
    bus: Rc<Bus>,
    /// The member's number, which stands for its process id.
    member: u32,
    /// `None` for observers, which never wait.
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
            pool: RefCell::default(),
            id: SenderId::in_process(self.member, number),
            limit: buffer_of(T::TOPIC, self.bus.limit),
            sealing: self.bus.sealing,
            moved: Rc::clone(&self.bus.moved),
            stalled: Rc::clone(&self.bus.stalled),
            pause: self.pause.clone(),
            end,
        })
    }

    pub(super) fn subscriber<T: Message>(&self) -> Rc<dyn Receiver<T>> {
        let queue = VecDeque::with_capacity(ROOM.min(self.bus.limit));
        let queue = Rc::new(Queue::<T>::new(queue));
        self.bus.queues::<T>().0.borrow_mut().push(Rc::downgrade(&queue));
        let sealing = self.bus.sealing;
        Rc::new(MemoryReceiver { queue, sealing, moved: Rc::clone(&self.bus.moved) })
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
struct MemorySender<T> {
    queues: Rc<Queues<T>>,
    /// Messages that were sent, oldest first: what no receiver has any more is written again.
    pool: RefCell<VecDeque<Rc<T>>>,
    id: SenderId,
    limit: usize,
    sealing: Sealing,
    moved: Rc<Cell<u64>>,
    stalled: Rc<Cell<bool>>,
    pause: Option<Pause>,
    end: End,
}

impl<T: Message> MemorySender<T> {
    /// Puts `message` into `queue`, waiting for room.
    fn put(&self, queue: &Queue<T>, message: &Rc<T>) -> Result<(), TransportError> {
        while queue.borrow().len() >= self.limit {
            if self.end.is_now() {
                return Ok(());
            }
            if self.stalled.get() {
                return Err(TransportError::NotRead);
            }
            match &self.pause {
                Some(pause) => pause.wait(),
                None => return Err(TransportError::Full),
            }
        }
        queue.borrow_mut().push_back((Rc::clone(message), self.id));
        self.moved.set(self.moved.get() + 1);
        Ok(())
    }
}

impl<T: Message> Connect for MemorySender<T> {
    fn connect(&self) -> Result<(), TransportError> {
        Ok(())
    }
}

impl<T: Message> Sender<T> for MemorySender<T> {
    fn loan(&self) -> Result<Loan<T>, TransportError> {
        let mut pool = self.pool.borrow_mut();
        let unused = pool.iter().position(|message| Rc::strong_count(message) == 1);
        let message = unused.and_then(|index| pool.remove(index));
        let message = message.unwrap_or_else(|| Rc::new(T::zeroed()));
        Ok(Loan(Place::Memory(message)))
    }

    fn send(&self, message: Loan<T>) -> Result<(), TransportError> {
        let Place::Memory(message) = message.0 else {
            return Err(TransportError::OtherCarrier);
        };
        // One look at a time: others may have their turn in between.
        let mut index = 0;
        loop {
            let next = self.queues.0.borrow().get(index).map(Weak::upgrade);
            match next {
                Some(Some(queue)) => self.put(&queue, &message)?,
                Some(None) => {}
                None => break,
            }
            index += 1;
        }
        self.pool.borrow_mut().push_back(message);
        Ok(())
    }

    fn sealing(&self) -> Sealing {
        self.sealing
    }
}

#[derive(Debug)]
struct MemoryReceiver<T> {
    queue: Rc<Queue<T>>,
    sealing: Sealing,
    moved: Rc<Cell<u64>>,
}

impl<T: Message> Connect for MemoryReceiver<T> {
    fn connect(&self) -> Result<(), TransportError> {
        Ok(())
    }
}

impl<T: Message> Input for MemoryReceiver<T> {
    fn has_input(&self) -> bool {
        !self.queue.borrow().is_empty()
    }
}

impl<T: Message> Receiver<T> for MemoryReceiver<T> {
    fn room(&self) -> Held<T> {
        Held::of_borrowed()
    }

    fn receive(&self, held: &mut Held<T>) -> Result<Option<Arrival>, TransportError> {
        let Some((message, sender)) = self.queue.borrow_mut().pop_front() else { return Ok(None) };
        self.moved.set(self.moved.get() + 1);
        held.take_shared(message);
        Ok(Some(Arrival { sender, copied_bytes: 0 }))
    }

    fn sealing(&self) -> Sealing {
        self.sealing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Command, Odometry, RadarDetections};

    fn bus() -> Rc<Bus> {
        let strides = [1, 5, 10, 10, 5, 10];
        let timetable = Timetable { step_ns: 10_000_000, strides, last_step: 100 };
        Rc::new(Bus::new(&timetable, Sealing::Sealed))
    }

    fn send(sender: &dyn Sender<Odometry>, sequence: u64) -> Result<(), TransportError> {
        let mut message = sender.loan()?;
        message.header.sequence = sequence;
        sender.send(message)
    }

    #[test]
    fn every_receiver_gets_every_message_in_order_with_its_sender() {
        let bus = bus();
        let (plant, other) = (Seat::new(Rc::clone(&bus), 1, None), Seat::new(bus, 4, None));
        let sender = plant.publisher::<Odometry>(End::default());
        let (one, two) = (other.subscriber::<Odometry>(), plant.subscriber::<Odometry>());
        let commands = other.subscriber::<Command>();
        send(&*sender, 1).expect("room");
        send(&*sender, 2).expect("room");
        for receiver in [one, two] {
            let mut held = Held::new();
            for sequence in 1..=2 {
                let arrival = receiver.receive(&mut held).expect("memory").expect("a message");
                let message = held.get().expect("taken");
                assert_eq!((message.header.sequence, arrival.sender.pid()), (sequence, 1));
                assert!(arrival.copied_bytes == 0 && held.is_as_sent());
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
        let full = (1..).find(|&k| send(&*sender, k).is_err());
        assert_eq!(full, Some(51), "as many as in shared memory");
        drop(receiver);
        send(&*sender, 52).expect("no receiver is left");
    }

    #[test]
    fn a_message_is_borrowed_and_not_written_again_before_its_readers_gave_it_back() {
        let seat = Seat::new(bus(), 1, None);
        let sender = seat.publisher::<RadarDetections>(End::default());
        let receiver = seat.subscriber::<RadarDetections>();
        let mut held = Held::new();
        let mut addresses = Vec::new();
        for count in 1..=6 {
            let mut message = sender.loan().expect("memory");
            message.count = count;
            addresses.push(std::ptr::from_ref::<RadarDetections>(&message));
            sender.send(message).expect("room");
            let before = held.get().map(|held: &RadarDetections| held.count);
            assert_eq!(before, (count > 1).then(|| count - 1), "what is held stays");
            let arrival = receiver.receive(&mut held).expect("memory").expect("a message");
            assert_eq!(arrival.copied_bytes, 0);
            assert_eq!(held.get().map(std::ptr::from_ref), addresses.last().copied());
        }
        addresses.sort_unstable();
        addresses.dedup();
        assert_eq!(addresses.len(), 2, "written in turn");
    }
}
