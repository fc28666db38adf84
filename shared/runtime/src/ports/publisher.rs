//! The sending end of a topic.
//!
//! A message is written where its readers will read it, and protected there:
//!
//! ```text
//! loan ─► the service writes ─► send: header ─► (decorator: false content) ─► Protection ─► handed over
//! ```
//!
//! A standby does not complete its message and does not hand it over. It keeps the newest one until it takes
//! over.

use super::tally::Tally;
use crate::survival::gate::{Gate, Passage};
use crate::transport::waking::Waker;
use crate::transport::{Loan, Sealing, Sender};
use crate::{Clock, RuntimeError, Timetable};
use messages::e2e::profile7;
use messages::{Message, Service};
use std::cell::RefCell;
use std::fmt::Debug;
use std::rc::Rc;

/// A consumer that lags this many steps behind is woken even if no sample is due.
const DRAIN_STEPS: u64 = 16;

/// The sending end of `T`'s topic.
#[derive(Debug)]
pub struct Publisher<T: Message> {
    port: Rc<dyn Sender<T>>,
    outlet: Rc<RefCell<Outlet<T>>>,
}

/// A stage that takes messages whose header is complete.
pub(crate) trait Outgoing<T: Message>: Debug {
    /// Takes the message over.
    fn send(&mut self, message: Loan<T>) -> Result<(), RuntimeError>;
}

/// Completes the header of a message and hands it to the next stage, if the gate lets it pass.
#[derive(Debug)]
pub(crate) struct Outlet<T: Message> {
    pub(crate) next: Box<dyn Outgoing<T>>,
    pub(crate) clock: Rc<Clock>,
    pub(crate) source: Service,
    pub(crate) incarnation: u32,
    pub(crate) tally: Rc<RefCell<Tally>>,
    pub(crate) gate: Rc<Gate>,
    /// A standby's newest message.
    pub(crate) held: Option<Loan<T>>,
}

/// The last stage: protects a message, counts it and hands it to the topic.
#[derive(Debug)]
pub(crate) struct Protection<T: Message> {
    pub(crate) port: Rc<dyn Sender<T>>,
    pub(crate) waker: Option<Waker>,
    pub(crate) timetable: Timetable,
    pub(crate) tally: Rc<RefCell<Tally>>,
}

/// A port with a message that was kept back.
pub(crate) trait Backlog: Debug {
    /// Sends it if it is of `step`; drops it if it is of an earlier one.
    fn send_held(&self, step: u64) -> Result<(), RuntimeError>;
}

impl<T: Message> Backlog for RefCell<Outlet<T>> {
    fn send_held(&self, step: u64) -> Result<(), RuntimeError> {
        let mut outlet = self.borrow_mut();
        match outlet.held.take() {
            Some(message) if message.header().step == step => outlet.hand_over(message).map(|_| ()),
            _ => Ok(()),
        }
    }
}

impl<T: Message> Publisher<T> {
    pub(crate) fn new(port: Rc<dyn Sender<T>>, outlet: Outlet<T>) -> Self {
        Self { port, outlet: Rc::new(RefCell::new(outlet)) }
    }

    /// The message that it keeps back.
    pub(crate) fn backlog(&self) -> Rc<dyn Backlog> {
        Rc::clone(&self.outlet) as Rc<dyn Backlog>
    }

    /// Memory for the next message, all zeros, where its readers will read it.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport has no memory.
    pub fn loan(&self) -> Result<Loan<T>, RuntimeError> {
        let mut message = self.loan_used()?;
        bytemuck::write_zeroes(&mut *message);
        Ok(message)
    }

    /// As [`Self::loan`], with an earlier message of this port in it, or zeros. It serves messages so large that only
    /// the parts that differ are to be written.
    ///
    /// # Errors
    /// As [`Self::loan`].
    pub fn loan_used(&self) -> Result<Loan<T>, RuntimeError> {
        self.port.loan().map_err(|reason| RuntimeError::Send { topic: T::TOPIC, reason })
    }

    /// Loans, lets `write` fill the zeros and sends.
    ///
    /// # Errors
    /// As [`Self::loan`] and [`Self::send`].
    pub fn send_with(&mut self, write: impl FnOnce(&mut T)) -> Result<i64, RuntimeError> {
        let mut message = self.loan()?;
        write(&mut message);
        self.send(message)
    }

    /// Completes the header of `message`, which was loaned here, in its place: sequence, source, publish
    /// stamp, protection. Then hands it over. Returns the publish stamp, ns of run time. Neither copies nor
    /// allocates. A standby keeps it and releases the previous one.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport refuses it, [`RuntimeError::Replaced`] if this process may
    /// not send any more.
    pub fn send(&mut self, message: Loan<T>) -> Result<i64, RuntimeError> {
        let mut outlet = self.outlet.borrow_mut();
        match outlet.gate.passage() {
            Passage::Open => outlet.hand_over(message),
            Passage::Held => {
                outlet.held = Some(message);
                Ok(outlet.clock.now_ns())
            }
            Passage::Shut => Err(RuntimeError::Replaced),
        }
    }
}

impl<T: Message> Outlet<T> {
    fn hand_over(&mut self, mut message: Loan<T>) -> Result<i64, RuntimeError> {
        let now_ns = self.clock.now_ns();
        let header = message.header_mut();
        header.sequence = self.tally.borrow().messages + 1;
        header.incarnation = self.incarnation;
        header.source = self.source.to_wire();
        header.publish_ns = now_ns;
        self.next.send(message)?;
        Ok(now_ns)
    }
}

impl<T: Message> Outgoing<T> for Protection<T> {
    fn send(&mut self, mut message: Loan<T>) -> Result<(), RuntimeError> {
        let header = message.header();
        let (step, data_id) = (header.step, T::TOPIC.data_id(header.source));
        // The counter is the sequence number's low half: it wraps.
        let counter = header.sequence as u32;
        let bytes = bytemuck::bytes_of_mut(&mut *message);
        let in_use = T::LAYOUT.bytes_in_use(bytes);
        let bytes = &mut bytes[..in_use];
        match self.port.sealing() {
            Sealing::Sealed => profile7::protect(bytes, data_id, counter),
            Sealing::Unsealed => profile7::mark(bytes, data_id, counter),
        }
        self.tally.borrow_mut().count_sent(&*message);
        let sent = self.port.send(message);
        sent.map_err(|reason| RuntimeError::Send { topic: T::TOPIC, reason })?;
        if let Some(waker) = &self.waker
            && (self.timetable.is_awaited(T::TOPIC, step) || step.is_multiple_of(DRAIN_STEPS))
        {
            waker.wake();
        }
        Ok(())
    }
}
