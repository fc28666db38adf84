//! A tap on the topics: every message as it was sent, unchecked, for recorders.

use crate::transport::{Held, Receiver, Seat, SharedMemory, Transport};
use crate::{Carried, Group, RuntimeError};
use messages::Message;
use std::cell::RefCell;
use std::rc::Rc;

/// A process that taps a running group.
#[derive(Debug)]
pub struct Tap {
    transport: Transport,
}

impl Tap {
    /// Joins `group` under `name`.
    ///
    /// # Errors
    /// If the run's shared memory is not usable.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        Ok(Self { transport: Transport::SharedMemory(SharedMemory::join(group, name)?) })
    }

    /// A tap in the process of the run.
    pub(crate) fn at(seat: Seat) -> Self {
        Self { transport: Transport::Memory(seat) }
    }

    /// Taps `T`'s topic from now on.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn on<T: Carried>(&self) -> Result<Tapped<T>, RuntimeError> {
        let port = T::receiver(&self.transport)?;
        Ok(Tapped { port, held: RefCell::new(Held::new()) })
    }
}

/// The messages of one topic, as a tap receives them.
#[derive(Debug)]
pub struct Tapped<T: Message> {
    port: Rc<dyn Receiver<T>>,
    held: RefCell<Held<T>>,
}

impl<T: Message> Tapped<T> {
    /// Hands the oldest message that was not yet taken to `each`; false if there is none.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn take(&self, each: impl FnOnce(&T)) -> Result<bool, RuntimeError> {
        let mut held = self.held.borrow_mut();
        let taken = self.port.receive(&mut held);
        let taken = taken.map_err(|reason| RuntimeError::Receive { topic: T::TOPIC, reason })?;
        if taken.is_some()
            && let Some(message) = held.get()
        {
            each(message);
        }
        held.clear();
        Ok(taken.is_some())
    }
}
