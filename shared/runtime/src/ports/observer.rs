//! A listener that takes no part in the run: the launcher.

use crate::ports::members::Members;
use crate::ports::{Checks, Tally, Wire};
use crate::report::ReceivedTopic;
use crate::survival::fence::Fences;
use crate::transport::{Seat, SharedMemory, Transport};
use crate::{Carried, Group, RuntimeError, Subscriber};
use messages::Message;
use std::rc::Rc;

/// A listener in a running group.
#[derive(Debug)]
pub struct Observer {
    transport: Transport,
    members: Rc<Members>,
    fences: Option<Fences>,
}

impl Observer {
    /// Joins `group` under `name`.
    ///
    /// # Errors
    /// If the run's shared memory is not usable.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let members = Rc::new(Members::of(&group.root));
        let transport = Transport::SharedMemory(SharedMemory::join(group, name)?);
        Ok(Self { transport, members, fences: Fences::of(group)? })
    }

    /// A listener in the process of a run.
    pub(crate) fn at(seat: Seat) -> Self {
        let transport = Transport::Memory(seat);
        Self { transport, members: Rc::new(Members::InProcess), fences: None }
    }

    /// Removes what dead processes left on the topics, so that no sender waits for them.
    pub fn remove_dead(&self) {
        self.transport.remove_dead();
    }

    /// Listens to `T`'s topic from now on.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn listen<T: Carried>(&self) -> Result<Observed<T>, RuntimeError> {
        let (port, tally) = (T::receiver(&self.transport)?, Tally::of_receiver());
        let wire = Wire::new(Rc::clone(&port), Rc::clone(&self.members), Rc::clone(&tally));
        let checks = Checks::new(self.fences.clone(), None, None, Rc::clone(&tally));
        Ok(Observed(Subscriber::new(port, None, Box::new(wire), checks, tally)))
    }
}

/// The messages of one topic, as an observer receives them.
#[derive(Debug)]
pub struct Observed<T: Message>(Subscriber<T>);

impl<T: Message> Observed<T> {
    /// Takes all messages that arrived, in order.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn drain(&mut self, each: impl FnMut(&T)) -> Result<(), RuntimeError> {
        self.0.drain(u64::MAX, each)
    }

    /// Messages received so far.
    #[must_use]
    pub fn received(&self) -> ReceivedTopic {
        self.0.tally().borrow().received(T::TOPIC)
    }
}
