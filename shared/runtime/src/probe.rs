//! The ends of a topic without a service around them: what `timegap bench` measures.
//!
//! Typed messages go through the services' own [`Publisher`] and [`Subscriber`]. Payloads of any size take the
//! same steps through the same node, iceoryx2 variant and wake-up: loaned, sent where they are, borrowed by
//! the reader. They are bare, or written, protected and checked in place as a large message is.
//! iceoryx2's own event service is here for comparison.

use crate::life::link::End;
use crate::ports::members::Members;
use crate::ports::{Checks, Outlet, Protection, Tally, Wire};
use crate::survival::gate::Gate;
use crate::transport::waking::{Waiter, Waker};
use crate::transport::{
    Ipc, PAYLOAD_TOPIC, Payload, Sealing, SharedMemory, Stamp, Transport, TransportError, refused,
};
use crate::{Carried, Clock, Group, Publisher, RuntimeError, Subscriber, monotonic_ns};
use iceoryx2::port::{listener::Listener, notifier::Notifier};
use messages::e2e::profile7;
use messages::{Message, Service};
use std::rc::Rc;
use std::time::Duration;

/// A member of a group that is no service.
#[derive(Debug)]
pub struct Probe {
    transport: Transport,
    group: Group,
}

impl Probe {
    /// Joins `group` under `name`.
    ///
    /// # Errors
    /// [`RuntimeError::Node`].
    pub fn join(group: Group, name: &str) -> Result<Self, RuntimeError> {
        let transport = Transport::SharedMemory(SharedMemory::join(&group, name)?);
        Ok(Self { transport, group })
    }

    fn node(&self) -> &SharedMemory {
        match &self.transport {
            Transport::SharedMemory(node) => node,
            Transport::Memory(_) => unreachable!("`join` joined shared memory"),
        }
    }

    /// The sending end of `T`'s topic, as `source` has it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn publisher<T: Carried>(&self, source: Service) -> Result<Publisher<T>, RuntimeError> {
        let port = T::sender(&self.transport, End::default())?;
        let tally = Tally::of_sender(self.group.mode, Sealing::Sealed);
        let protection = Protection {
            port: Rc::clone(&port),
            waker: self.transport.waker(T::TOPIC),
            timetable: self.group.timetable,
            tally: Rc::clone(&tally),
        };
        let outlet = Outlet {
            next: Box::new(protection),
            clock: Rc::new(Clock::new(self.group.mode, self.group.timetable.step_ns)),
            source,
            incarnation: 0,
            tally,
            gate: Rc::new(Gate::open(source)),
            held: None,
        };
        Ok(Publisher::new(port, outlet))
    }

    /// The receiving end of `T`'s topic, as a service that it releases has it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn subscriber<T: Carried>(&self) -> Result<Subscriber<T>, RuntimeError> {
        let waiter = Some(self.transport.waiter(T::TOPIC));
        let (port, tally) = (T::receiver(&self.transport)?, Tally::of_receiver());
        let members = Rc::new(Members::of(&self.group.root));
        let wire = Wire::new(Rc::clone(&port), members, Rc::clone(&tally));
        let checks = Checks::new(None, None, None, Rc::clone(&tally));
        Ok(Subscriber::new(port, waiter, Box::new(wire), checks, tally))
    }

    /// Waits for samples of `T`'s topic, at most for `timeout`, and hands all to `each`.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn next_samples<T: Message>(
        &self,
        topic: &mut Subscriber<T>,
        timeout: Duration,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        let ticket = topic.ticket();
        let mut found = false;
        topic.drain(u64::MAX, |sample| {
            found = true;
            each(sample);
        })?;
        if found {
            return Ok(());
        }
        topic.wait(ticket, timeout)?;
        topic.drain(u64::MAX, each)
    }

    /// The sending end for payloads of `bytes`.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn payload_sender(
        &self,
        bytes: usize,
        contents: Contents,
    ) -> Result<PayloadSender, RuntimeError> {
        let port = (self.node().payload_topic(bytes)?.publisher_builder())
            .initial_max_slice_len(bytes)
            .create()
            .map_err(refused(PAYLOAD_TOPIC))?;
        let waker = self.node().waker(PAYLOAD_TOPIC);
        Ok(PayloadSender { port, waker, bytes, contents, sent: 0 })
    }

    /// The receiving end for payloads of `bytes`.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn payload_receiver(
        &self,
        bytes: usize,
        contents: Contents,
    ) -> Result<PayloadReceiver, RuntimeError> {
        let port = (self.node().payload_topic(bytes)?.subscriber_builder())
            .create()
            .map_err(refused(PAYLOAD_TOPIC))?;
        let waiter = self.transport.waiter(PAYLOAD_TOPIC);
        Ok(PayloadReceiver { port, waiter, contents })
    }

    /// The waking end of iceoryx2's own event service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn event_sender(&self) -> Result<EventSender, RuntimeError> {
        let port =
            (self.node().event()?.notifier_builder()).create().map_err(refused(PAYLOAD_TOPIC))?;
        Ok(EventSender(port))
    }

    /// The waiting end of iceoryx2's own event service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn event_receiver(&self) -> Result<EventReceiver, RuntimeError> {
        let port =
            (self.node().event()?.listener_builder()).create().map_err(refused(PAYLOAD_TOPIC))?;
        Ok(EventReceiver(port))
    }
}

/// Data ID of protected payloads.
const PAYLOAD_DATA_ID: u32 = PAYLOAD_TOPIC.data_id(Service::PerceptionSim.to_wire());

/// What is done with the bytes of a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Nothing: they are handed over.
    Bare,
    /// The sender writes and protects them, the reader checks them, all in place.
    Protected,
}

/// Sends payloads.
#[derive(Debug)]
pub struct PayloadSender {
    port: iceoryx2::port::publisher::Publisher<Ipc, Payload, Stamp>,
    waker: Waker,
    bytes: usize,
    contents: Contents,
    sent: u32,
}

impl PayloadSender {
    /// Loans a payload, stamps it with the time before the loan, sends it and wakes who waits.
    ///
    /// # Errors
    /// [`RuntimeError::Send`].
    #[expect(unsafe_code, reason = "a payload is not written to please the type")]
    pub fn send(&mut self) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Send { topic: PAYLOAD_TOPIC, reason };
        let sent_ns = monotonic_ns();
        let sample = self.port.loan_slice_uninit(self.bytes);
        let mut sample = sample.map_err(TransportError::iceoryx2).map_err(error)?;
        sample.user_header_mut().sent_ns = sent_ns;
        // SAFETY: the payload is a part of a file in memory, mapped by this process: it holds zeros or an
        // earlier payload.
        let mut sample = unsafe { sample.assume_init() };
        self.sent = self.sent.wrapping_add(1);
        if self.contents == Contents::Protected {
            let bytes = sample.payload_mut();
            bytes.fill(self.sent as u8);
            profile7::protect(bytes, PAYLOAD_DATA_ID, self.sent);
        }
        sample.send().map_err(TransportError::iceoryx2).map_err(error)?;
        self.waker.wake();
        Ok(())
    }
}

/// Receives payloads.
#[derive(Debug)]
pub struct PayloadReceiver {
    port: iceoryx2::port::subscriber::Subscriber<Ipc, Payload, Stamp>,
    waiter: Waiter,
    contents: Contents,
}

impl PayloadReceiver {
    /// Waits for payloads, at most for `timeout`; hands the stamp of each one to `each`, after its check
    /// if it is protected.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`], also of a payload that does not pass its check.
    pub fn next(&self, timeout: Duration, mut each: impl FnMut(i64)) -> Result<(), RuntimeError> {
        let ticket = self.waiter.ticket();
        if self.take(&mut each)? {
            return Ok(());
        }
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        let waited = self.waiter.wait(ticket, timeout);
        waited.map_err(|reason| error(TransportError::System { what: "waiting", reason }))?;
        self.take(&mut each).map(|_| ())
    }

    fn take(&self, each: &mut impl FnMut(i64)) -> Result<bool, RuntimeError> {
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        let mut found = false;
        while let Some(sample) =
            self.port.receive().map_err(TransportError::iceoryx2).map_err(error)?
        {
            found = true;
            if self.contents == Contents::Protected {
                let checked = profile7::check(sample.payload(), PAYLOAD_DATA_ID);
                checked.map_err(|corrupted| error(TransportError::Corrupted(corrupted)))?;
            }
            each(sample.user_header().sent_ns);
        }
        Ok(found)
    }
}

/// Wakes by iceoryx2's event service.
#[derive(Debug)]
pub struct EventSender(Notifier<Ipc>);

impl EventSender {
    /// Wakes who waits.
    ///
    /// # Errors
    /// [`RuntimeError::Send`].
    pub fn wake(&self) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Send { topic: PAYLOAD_TOPIC, reason };
        self.0.notify().map(|_| ()).map_err(TransportError::iceoryx2).map_err(error)
    }
}

/// Waits by iceoryx2's event service.
#[derive(Debug)]
pub struct EventReceiver(Listener<Ipc>);

impl EventReceiver {
    /// Waits to be woken, at most for `timeout`.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn wait(&self, timeout: Duration) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        self.0
            .timed_wait(|_| {}, timeout)
            .map(|_| ())
            .map_err(TransportError::iceoryx2)
            .map_err(error)
    }
}
