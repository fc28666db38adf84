//! A sender of recorded messages: the replayer.

use crate::life::link::End;
use crate::transport::waking::Waker;
use crate::transport::{Seat, Sender, SharedMemory, Transport, TransportError};
use crate::{Carried, Group, RuntimeError};
use messages::Message;
use std::rc::Rc;

/// A process that plays messages into a group.
#[derive(Debug)]
pub struct Player {
    transport: Transport,
}

impl Player {
    /// Joins `group` under `name`.
    ///
    /// # Errors
    /// If the run's shared memory is not usable.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        Ok(Self { transport: Transport::SharedMemory(SharedMemory::join(group, name)?) })
    }

    /// A player in the process of a run.
    pub(crate) fn at(seat: Seat) -> Self {
        Self { transport: Transport::Memory(seat) }
    }

    /// Opens the sending end of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn on<T: Carried>(&self) -> Result<Played<T>, RuntimeError> {
        let port = T::sender(&self.transport, End::default())?;
        Ok(Played { port, waker: self.transport.waker(T::TOPIC) })
    }
}

/// The sending end of `T`'s topic for messages that are complete.
#[derive(Debug)]
pub struct Played<T: Message> {
    port: Rc<dyn Sender<T>>,
    waker: Option<Waker>,
}

impl<T: Message> Played<T> {
    /// Sends the message whose bytes these are as it is, and wakes who waits for it.
    ///
    /// # Errors
    /// [`RuntimeError::Send`], also for as many bytes as no message of the type has.
    pub fn send(&self, bytes: &[u8]) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Send { topic: T::TOPIC, reason };
        let mut message = self.port.loan().map_err(error)?;
        let place = bytemuck::bytes_of_mut(&mut *message);
        if place.len() != bytes.len() {
            return Err(error(TransportError::Length(bytes.len())));
        }
        place.copy_from_slice(bytes);
        self.port.send(message).map_err(error)?;
        if let Some(waker) = &self.waker {
            waker.wake();
        }
        Ok(())
    }
}
