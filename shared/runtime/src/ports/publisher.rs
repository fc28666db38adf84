//! The sending end of a topic.

use super::seal::{Backlog, Seal};
use crate::RuntimeError;
use crate::transport::Loan;
use messages::Message;
use std::cell::RefCell;
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
        let loan = self.0.borrow().outlet.loan();
        loan.map_err(|reason| RuntimeError::Send { topic: T::TOPIC, reason })
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
        self.0.borrow_mut().send(message)
    }
}
