//! The sending end of a topic, and the seal of a message that a service wrote: header, protection, counts.

use super::Tally;
use crate::faults::Falsified;
use crate::survival::fence::{Gate, Passage};
use crate::transport::waking::Waker;
use crate::transport::{Loan, Sender};
use crate::{Clock, RuntimeError, Timetable};
use messages::e2e::profile7;
use messages::{Message, Service};
use std::cell::RefCell;
use std::fmt::Debug;
use std::rc::Rc;

/// The sending end of `T`'s topic. A message is written where its readers will read it.
#[derive(Debug)]
pub struct Publisher<T: Message>(Rc<RefCell<Seal<T>>>);

impl<T: Message> Publisher<T> {
    pub(crate) fn new(seal: Seal<T>) -> Self {
        Self(Rc::new(RefCell::new(seal)))
    }

    /// The message that it keeps back.
    pub(crate) fn backlog(&self) -> Rc<dyn Backlog> {
        Rc::clone(&self.0) as Rc<dyn Backlog>
    }

    /// Memory for the next message, all zeros, where its readers will read it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`] if the transport has no memory.
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
        let loan = self.0.borrow().port.loan();
        loan.map(Loan::at).map_err(RuntimeError::topic("send on", T::TOPIC))
    }

    /// Loans, lets `write` fill the zeros and sends.
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
    /// [`RuntimeError::Topic`] if the transport refuses it, [`RuntimeError::Replaced`] if this process may
    /// not send any more.
    pub fn send(&mut self, message: Loan<T>) -> Result<i64, RuntimeError> {
        self.0.borrow_mut().send(message)
    }
}

/// A consumer that lags this many steps behind is woken even if no sample is due.
const DRAIN_STEPS: u64 = 16;

/// Completes messages and hands them over. A standby does not: it keeps the newest one until it takes over.
#[derive(Debug)]
pub(crate) struct Seal<T: Message> {
    pub(crate) port: Rc<Sender>,
    /// Wakes the receivers, and when.
    pub(crate) waker: Option<(Waker, Timetable)>,
    /// Faults of the content; `None` where none can come to act.
    pub(crate) falsified: Option<Falsified<T>>,
    /// Messages get their end-to-end protection, and a place in the digest.
    pub(crate) protects: bool,
    pub(crate) clock: Rc<Clock>,
    pub(crate) source: Service,
    pub(crate) incarnation: u32,
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

impl<T: Message> Backlog for RefCell<Seal<T>> {
    fn send_held(&self, step: u64) -> Result<(), RuntimeError> {
        let mut seal = self.borrow_mut();
        match seal.held.take() {
            Some(message) if message.header().step == step => seal.hand_over(message).map(|_| ()),
            _ => Ok(()),
        }
    }
}

impl<T: Message> Seal<T> {
    /// Hands `message` over if the gate lets it pass; returns the publish stamp.
    pub(super) fn send(&mut self, message: Loan<T>) -> Result<i64, RuntimeError> {
        match self.gate.passage() {
            Passage::Open => self.hand_over(message),
            Passage::Held => {
                self.held = Some(message);
                Ok(self.clock.now_ns())
            }
            Passage::Shut => Err(RuntimeError::Replaced),
        }
    }

    fn hand_over(&mut self, mut message: Loan<T>) -> Result<i64, RuntimeError> {
        let now_ns = self.clock.now_ns();
        let sequence = self.tally.borrow_mut().next();
        let header = message.header_mut();
        header.sequence = sequence;
        header.incarnation = self.incarnation;
        header.source = self.source.to_wire();
        header.publish_ns = now_ns;
        let step = header.step;
        if let Some(falsified) = &mut self.falsified {
            falsified.apply(&mut message, now_ns);
        }
        if self.protects {
            let data_id = T::TOPIC.data_id(self.source.to_wire());
            let bytes = bytemuck::bytes_of_mut(&mut *message);
            let in_use = T::LAYOUT.bytes_in_use(bytes);
            // The counter is the sequence number's low half: it wraps.
            profile7::protect(&mut bytes[..in_use], data_id, sequence as u32);
            self.tally.borrow_mut().digest(&bytes[..in_use]);
        }
        let sent = self.port.send(message.0, step);
        sent.map_err(RuntimeError::topic("send on", T::TOPIC))?;
        if let Some((waker, timetable)) = &self.waker
            && (timetable.is_awaited(T::TOPIC, step) || step.is_multiple_of(DRAIN_STEPS))
        {
            waker.wake();
        }
        Ok(now_ns)
    }
}
