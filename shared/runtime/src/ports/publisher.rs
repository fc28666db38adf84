//! The sending end of a topic.
//!
//! A message is written where its readers will read it, and protected there:
//!
//! ```text
//! loan ─► the service writes ─► send: header, sender faults, protection ─► handed over
//! ```
//!
//! A standby's message is not completed and not handed over; the newest one is kept for the instant at which
//! the standby takes over.

use super::tally::Tally;
use crate::faults::{Faults, SenderFaults};
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

/// What completes a message and hands it over.
#[derive(Debug)]
pub(crate) struct Outlet<T: Message> {
    pub(crate) port: Rc<dyn Sender<T>>,
    pub(crate) waker: Option<Waker>,
    pub(crate) clock: Rc<Clock>,
    pub(crate) timetable: Timetable,
    pub(crate) source: Service,
    pub(crate) incarnation: u32,
    pub(crate) faults: Rc<Faults>,
    pub(crate) sender_faults: SenderFaults<T>,
    pub(crate) tally: Rc<RefCell<Tally>>,
    pub(crate) gate: Rc<Gate>,
    /// A standby's newest message.
    pub(crate) held: Option<Loan<T>>,
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
    pub(crate) fn new(outlet: Outlet<T>) -> Self {
        Self { port: Rc::clone(&outlet.port), outlet: Rc::new(RefCell::new(outlet)) }
    }

    /// What it keeps back.
    pub(crate) fn backlog(&self) -> Rc<dyn Backlog> {
        Rc::clone(&self.outlet) as Rc<dyn Backlog>
    }

    /// Memory for the next message, all zeros, where its readers will read it.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport has none.
    pub fn loan(&self) -> Result<Loan<T>, RuntimeError> {
        let mut message = self.loan_used()?;
        bytemuck::write_zeroes(&mut *message);
        Ok(message)
    }

    /// As [`Self::loan`], with an earlier message of this port in it, or zeros: for messages so large
    /// that only the parts that differ are to be written.
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

    /// Completes the header of `message` (sequence, source, publish stamp, protection), which was loaned
    /// here, where it is, and hands it over. Returns the publish stamp, ns of run time. Neither copies
    /// nor allocates. Of a standby it is kept instead, and the one before it given back.
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
        let source = self.source.to_wire();
        let sequence = self.tally.borrow().messages + 1;
        let now_ns = self.clock.now_ns();
        let header = message.header_mut();
        header.sequence = sequence;
        header.incarnation = self.incarnation;
        header.source = source;
        header.publish_ns = now_ns;
        let step = header.step;
        self.faults.observe(|| message.drive(), now_ns);
        if self.faults.falsifies(T::TOPIC) {
            self.sender_faults.apply(&mut message, &self.faults, now_ns);
        }
        // The counter is the sequence number's low half: it wraps.
        let data_id = T::TOPIC.data_id(source);
        let (bytes, counter) = (bytemuck::bytes_of_mut(&mut *message), sequence as u32);
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
        Ok(now_ns)
    }
}
