//! The sending end of a topic.
//!
//! A message is written where its readers will read it, and protected there:
//!
//! ```text
//! loan ─► the service writes ─► send: header, sender faults, protection ─► handed over
//! ```

use super::tally::Tally;
use crate::faults::{Faults, SenderFaults};
use crate::transport::{Loan, Sender};
use crate::waking::Waker;
use crate::{Clock, RuntimeError, Timetable};
use messages::e2e::profile7;
use messages::{Message, Service};
use std::cell::RefCell;
use std::rc::Rc;

/// A consumer that lags this many steps behind is woken even if no sample is due.
const DRAIN_STEPS: u64 = 16;

/// The sending end of `T`'s topic.
#[derive(Debug)]
pub struct Publisher<T: Message> {
    pub(crate) port: Rc<dyn Sender<T>>,
    pub(crate) waker: Option<Waker>,
    pub(crate) clock: Rc<Clock>,
    pub(crate) timetable: Timetable,
    pub(crate) source: Service,
    pub(crate) incarnation: u32,
    pub(crate) faults: Rc<Faults>,
    pub(crate) sender_faults: SenderFaults<T>,
    pub(crate) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Publisher<T> {
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
    /// nor allocates.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport refuses it.
    pub fn send(&mut self, mut message: Loan<T>) -> Result<i64, RuntimeError> {
        let source = self.source.to_wire();
        let sequence = self.tally.borrow().messages + 1;
        let now_ns = self.clock.now_ns();
        let header = message.header_mut();
        header.sequence = sequence;
        header.incarnation = self.incarnation;
        header.source = source;
        header.publish_ns = now_ns;
        let step = header.step;
        if self.faults.in_use() {
            if let Some(drive) = message.drive() {
                self.faults.observe(&drive, now_ns);
            }
            self.sender_faults.apply(&mut message, &self.faults, now_ns);
        }
        // The counter is the sequence number's low half: it wraps.
        let data_id = T::TOPIC.data_id(source);
        profile7::protect(bytemuck::bytes_of_mut(&mut *message), data_id, sequence as u32);
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
