//! The ends of topics without a service around them: those of the launcher, of the recorder, of measurements.
//!
//! A guest can also open iceoryx2 services that no topic uses, in the same node and variant. It can wake those who wait
//! for a topic. So a program can send bytes of any size as the topics' messages are sent. `timegap bench` does.

use super::{Check, Publisher, Seal, Subscriber, Tally};
use crate::life::link::End;
use crate::survival::fence::Gate;
use crate::transport::waking::Waker;
use crate::transport::{Ipc, Receiver, Seat, Sender, SharedMemory, Transport, Wanted};
use crate::{Clock, Group, Mode, RuntimeError, Timetable, TransportError};
use iceoryx2::prelude::ServiceName;
use iceoryx2::service::builder::Builder;
use messages::{Header, Message, Service, Topic};
use std::rc::Rc;
use std::time::Duration;

/// A process of a group that is not a service, or the caller of a run in its own process.
#[derive(Debug)]
pub struct Guest {
    transport: Transport,
    mode: Mode,
    timetable: Timetable,
}

impl Guest {
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let &Group { mode, timetable, .. } = group;
        let transport = Transport::SharedMemory(SharedMemory::join(group, name)?);
        Ok(Self { transport, mode, timetable })
    }

    /// A listener in the process of a run.
    pub(crate) fn at(seat: Seat, timetable: Timetable) -> Self {
        Self { transport: Transport::Memory(seat), mode: Mode::Lockstep, timetable }
    }

    /// Begins to open an iceoryx2 service that is not a topic.
    ///
    /// # Panics
    /// In the process of a run, which has no such services.
    pub fn service(&self, name: &ServiceName) -> Builder<Ipc> {
        match &self.transport {
            Transport::SharedMemory(node) => node.service(name),
            Transport::Memory(_) => panic!("a process of a group opens services of iceoryx2"),
        }
    }

    /// Removes what dead processes left on all topics, so that no sender waits for them.
    pub fn remove_dead(&self) {
        self.transport.remove_dead();
    }

    /// Wakes those who wait for `topic`, and waits for it.
    ///
    /// # Panics
    /// In the process of a run, in which services wait for their turns.
    pub fn waker(&self, topic: Topic) -> Waker {
        self.transport.waker(topic).expect("processes wake each other")
    }

    /// The sending end of `T`'s topic, as `source` has it.
    pub fn publisher<T: Message>(&self, source: Service) -> Result<Publisher<T>, RuntimeError> {
        let &Self { mode, timetable, .. } = self;
        Ok(Publisher::new(Seal {
            port: self.transport.sender(T::TOPIC, End::default())?,
            waker: self.transport.waker(T::TOPIC).map(|waker| (waker, timetable)),
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

    /// The receiving end of `T`'s topic, as a service that it releases has it. In the process of a run it cannot wait.
    pub fn subscriber<T: Message>(&self) -> Result<Subscriber<T>, RuntimeError> {
        let (peers, tally) = (self.transport.peers(), Rc::default());
        let waiter = peers.map(|_| self.transport.waiter(T::TOPIC));
        // Faults act on the channels of services alone.
        let check = Check::new(peers, peers.is_some(), Rc::clone(&tally));
        let port = self.transport.receiver(T::TOPIC, Wanted::Every)?;
        Ok(Subscriber::new(port, waiter, None, check, tally))
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

    /// Taps a topic from now on: each message as it was sent, unchecked.
    pub fn tap(&self, topic: Topic) -> Result<Tapped, RuntimeError> {
        Ok(Tapped { topic, port: self.transport.receiver(topic, Wanted::Every)? })
    }

    /// Opens the sending end of a topic for messages that are complete.
    pub fn player(&self, topic: Topic) -> Result<Played, RuntimeError> {
        let port = self.transport.sender(topic, End::default())?;
        Ok(Played { topic, port, waker: self.waker(topic) })
    }
}

/// The messages of one topic, as a tap receives them.
#[derive(Debug)]
pub struct Tapped {
    pub topic: Topic,
    port: Rc<Receiver>,
}

impl Tapped {
    /// Hands the bytes of the oldest message that was not yet taken to `each`; false if there is none.
    pub fn take(&self, each: impl FnOnce(&[u8])) -> Result<bool, RuntimeError> {
        let taken = self.port.receive().map_err(RuntimeError::topic("receive on", self.topic))?;
        Ok(taken.map(|(message, _)| each(message.bytes())).is_some())
    }
}

/// The sending end of a topic for messages that are complete, as recorded ones are.
#[derive(Debug)]
pub struct Played {
    topic: Topic,
    port: Rc<Sender>,
    waker: Waker,
}

impl Played {
    /// Sends the message whose bytes these are as it is, and wakes who waits for it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`], also for as many bytes as no message of the topic has.
    pub fn send(&self, bytes: &[u8]) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Topic("send on", self.topic, reason);
        if bytes.len() != self.topic.message_bytes() {
            return Err(error(TransportError::Refused("bytes that are not such a message")));
        }
        let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
        let mut message = self.port.loan().map_err(error)?;
        message.bytes_mut().copy_from_slice(bytes);
        self.port.send(message, header.step).map_err(error)?;
        self.waker.wake();
        Ok(())
    }
}
