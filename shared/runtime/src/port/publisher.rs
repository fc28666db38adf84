//! The sending end of a topic.

use super::tally::Tally;
use crate::faults::{Faults, SenderFaults};
use crate::transport::Sender;
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
    /// Completes the header of `message` (sequence, source, publish stamp, protection) and sends it.
    /// Allocates nothing.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport refuses it.
    pub fn send(&mut self, message: T) -> Result<(), RuntimeError> {
        self.send_stamped(message).map(|_| ())
    }

    /// As [`Self::send`]; returns the publish stamp, ns of run time.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn send_stamped(&mut self, mut message: T) -> Result<i64, RuntimeError> {
        let error = |reason: String| RuntimeError::Send { topic: T::TOPIC, reason };
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
            if let Some((position_m, speed_mps)) = message.ego() {
                self.faults.ego_at(position_m, speed_mps, now_ns);
            }
            self.sender_faults.apply(&mut message, &self.faults, now_ns);
        }
        // The counter is the sequence number's low half: it wraps.
        let data_id = T::TOPIC.data_id(source);
        profile7::protect(bytemuck::bytes_of_mut(&mut message), data_id, sequence as u32);
        self.port.send(&message).map_err(error)?;
        self.tally.borrow_mut().count(&message);
        if let Some(waker) = &self.waker
            && (self.timetable.is_awaited(T::TOPIC, step) || step.is_multiple_of(DRAIN_STEPS))
        {
            waker.wake();
        }
        Ok(now_ns)
    }
}
