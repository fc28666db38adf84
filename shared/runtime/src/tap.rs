//! A tap on the topics: every message as it was sent, unchecked, for recorders.

use super::transport::{Receiver, Seat, SharedMemory, Transport};
use super::{Carried, Group, RuntimeError};
use messages::Message;
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
    pub(super) fn at(seat: Seat) -> Self {
        Self { transport: Transport::Memory(seat) }
    }

    /// Taps `T`'s topic from now on.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn on<T: Carried>(&self) -> Result<Tapped<T>, RuntimeError> {
        Ok(Tapped(T::receiver(&self.transport)?))
    }
}

/// What a tap hears on one topic.
#[derive(Debug)]
pub struct Tapped<T>(Rc<dyn Receiver<T>>);

impl<T: Message> Tapped<T> {
    /// The oldest message that was not yet taken.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn take(&self) -> Result<Option<T>, RuntimeError> {
        let taken = self.0.receive();
        let taken = taken.map_err(|reason| RuntimeError::Receive { topic: T::TOPIC, reason })?;
        Ok(taken.map(|(message, _)| message))
    }
}
