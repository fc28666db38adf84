//! The ends of topics without a service around them: those of the launcher, of the recorder, of measurements.
//!
//! A guest can also open iceoryx2 services that no topic uses, in the same node and variant. It can wake those who wait
//! for a topic. So a program can send bytes of any size as the topics' messages are sent. `timegap bench` does.

use super::{Check, Publisher, Seal, Subscriber, Tally};
use crate::life::link::End;
use crate::survival::fence::Gate;
use crate::transport::waking::{Waiter, Waker};
use crate::transport::{Held, Ipc, Receiver, Seat, Sender, SharedMemory, Transport, Wanted};
use crate::{Clock, Group, Mode, RuntimeError, Timetable, TransportError};
use iceoryx2::prelude::ServiceName;
use iceoryx2::service::builder::Builder;
use messages::{Message, Service, Topic};
use std::cell::RefCell;
use std::marker::PhantomData;
use std::rc::Rc;
use std::time::Duration;

/// A listener in a running group: the launcher.
#[derive(Debug)]
pub struct Observer(Transport);

impl Observer {
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        SharedMemory::join(group, name).map(Transport::SharedMemory).map(Self)
    }

    /// A listener in the process of a run.
    pub(crate) fn at(seat: Seat) -> Self {
        Self(Transport::Memory(seat))
    }

    /// Removes what dead processes left on the topics, so that no sender waits for them.
    pub fn remove_dead(&self) {
        self.0.remove_dead();
    }

    /// Listens to `T`'s topic from now on.
    pub fn listen<T: Message>(&self) -> Result<Subscriber<T>, RuntimeError> {
        let (port, tally) = (self.0.receiver(T::TOPIC, Wanted::Every)?, Rc::default());
        // Faults act on the channels of services alone.
        let check = Check::new(self.0.peers(), self.0.peers().is_some(), Rc::clone(&tally));
        Ok(Subscriber::new(port, None, None, check, tally))
    }
}

/// A process of a group that is not a service.
#[derive(Debug)]
pub struct Guest {
    node: SharedMemory,
    mode: Mode,
    timetable: Timetable,
}

impl Guest {
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let &Group { mode, timetable, .. } = group;
        Ok(Self { node: SharedMemory::join(group, name)?, mode, timetable })
    }

    /// Begins to open an iceoryx2 service that is not a topic.
    pub fn service(&self, name: &ServiceName) -> Builder<Ipc> {
        self.node.service(name)
    }

    /// Removes what dead processes left on all topics.
    pub fn remove_dead(&self) {
        self.node.remove_dead();
    }

    /// Wakes those who wait for `topic`, and waits for it.
    pub fn waker(&self, topic: Topic) -> Waker {
        Waker::new(&self.node.peers.words, topic)
    }

    fn sender(&self, topic: Topic) -> Result<Rc<Sender>, RuntimeError> {
        Ok(Rc::new(Sender::SharedMemory(self.node.sender(topic, End::default())?)))
    }

    fn receiver(&self, topic: Topic) -> Result<Rc<Receiver>, RuntimeError> {
        Ok(Rc::new(Receiver::SharedMemory(self.node.receiver(topic)?)))
    }

    /// The sending end of `T`'s topic, as `source` has it.
    pub fn publisher<T: Message>(&self, source: Service) -> Result<Publisher<T>, RuntimeError> {
        let &Self { mode, timetable, .. } = self;
        Ok(Publisher::new(Seal {
            port: self.sender(T::TOPIC)?,
            waker: Some((self.waker(T::TOPIC), timetable)),
            falsified: None,
            protects: true,
            clock: Rc::new(Clock::new(mode, timetable.step_ns)),
            source,
            incarnation: 0,
            tally: Tally::of_sender(mode == Mode::Lockstep),
            gate: Rc::new(Gate::of(None, source, 0)),
            held: None,
        }))
    }

    /// The receiving end of `T`'s topic, as a service that it releases has it.
    pub fn subscriber<T: Message>(&self) -> Result<Subscriber<T>, RuntimeError> {
        let tally = Rc::default();
        let check = Check::new(Some(&self.node.peers), true, Rc::clone(&tally));
        let waiter = Some(Waiter::Futex(self.waker(T::TOPIC)));
        Ok(Subscriber::new(self.receiver(T::TOPIC)?, waiter, None, check, tally))
    }

    /// Waits for samples of `T`'s topic, at most for `timeout`, and hands all to `each`.
    pub fn next_samples<T: Message>(
        &self,
        topic: &mut Subscriber<T>,
        timeout: Duration,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        let ticket = topic.ticket();
        let mut found = false;
        topic.drain(|sample| {
            found = true;
            each(sample);
        })?;
        if found {
            return Ok(());
        }
        topic.wait(ticket, timeout)?;
        topic.drain(each)
    }

    /// Taps `T`'s topic from now on: each message as it was sent, unchecked.
    pub fn tap<T: Message>(&self) -> Result<Tapped<T>, RuntimeError> {
        let port = self.receiver(T::TOPIC)?;
        Ok(Tapped { held: RefCell::new(port.room()), port })
    }

    /// Opens the sending end of `T`'s topic for messages that are complete.
    pub fn player<T: Message>(&self) -> Result<Played<T>, RuntimeError> {
        let (port, waker) = (self.sender(T::TOPIC)?, self.waker(T::TOPIC));
        Ok(Played { port, waker, message: PhantomData })
    }
}

/// The messages of one topic, as a tap receives them.
#[derive(Debug)]
pub struct Tapped<T: Message> {
    port: Rc<Receiver>,
    held: RefCell<Held<T>>,
}

impl<T: Message> Tapped<T> {
    /// Hands the oldest message that was not yet taken to `each`; false if there is none.
    pub fn take(&self, each: impl FnOnce(&T)) -> Result<bool, RuntimeError> {
        let mut held = self.held.borrow_mut();
        let taken = self.port.receive(&mut held);
        let taken = taken.map_err(RuntimeError::topic("receive on", T::TOPIC))?;
        if let (Some(_), Some(message)) = (&taken, held.get()) {
            each(message);
        }
        held.clear();
        Ok(taken.is_some())
    }
}

/// The sending end of `T`'s topic for messages that are complete, as recorded ones are.
#[derive(Debug)]
pub struct Played<T> {
    port: Rc<Sender>,
    waker: Waker,
    message: PhantomData<T>,
}

impl<T: Message> Played<T> {
    /// Sends the message whose bytes these are as it is, and wakes who waits for it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`], also for as many bytes as no message of the type has.
    pub fn send(&self, bytes: &[u8]) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Topic("send on", T::TOPIC, reason);
        let mut message = self.port.loan::<T>().map_err(error)?;
        let place = bytemuck::bytes_of_mut(&mut *message);
        if place.len() != bytes.len() {
            return Err(error(TransportError::Refused("bytes that are not such a message")));
        }
        place.copy_from_slice(bytes);
        self.port.send(message).map_err(error)?;
        self.waker.wake();
        Ok(())
    }
}
