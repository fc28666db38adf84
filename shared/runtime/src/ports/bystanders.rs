//! Ends of topics that take no part in the run: the launcher's, the recorder's, the replayer's.

use super::{Check, Subscriber, Tally};
use crate::life::link::End;
use crate::ports::members::Members;
use crate::report::ReceivedTopic;
use crate::survival::fence::Fences;
use crate::transport::waking::Waker;
use crate::transport::{Held, Inlet, Outlet, Seat, SharedMemory, Transport, Wanted};
use crate::{Group, RuntimeError, TransportError};
use messages::Message;
use std::cell::RefCell;
use std::rc::Rc;

/// A listener in a running group: the launcher.
#[derive(Debug)]
pub struct Observer {
    transport: Transport,
    members: Option<Rc<Members>>,
    fences: Option<Fences>,
}

impl Observer {
    /// Joins `group` under `name`.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let members = Some(Rc::new(Members::of(&group.root)));
        Ok(Self { transport: join(group, name)?, members, fences: Fences::of(group)? })
    }

    /// A listener in the process of a run.
    pub(crate) fn at(seat: Seat) -> Self {
        Self { transport: Transport::Memory(seat), members: None, fences: None }
    }

    /// Removes what dead processes left on the topics, so that no sender waits for them.
    pub fn remove_dead(&self) {
        self.transport.remove_dead();
    }

    /// Listens to `T`'s topic from now on.
    pub fn listen<T: Message>(&self) -> Result<Observed<T>, RuntimeError> {
        let (inlet, tally) =
            (self.transport.inlet(Wanted::Every)?, Rc::<RefCell<Tally>>::default());
        // Faults act on the channels of services alone.
        let is_judged = self.members.is_some();
        let mut check = Check::new(self.members.clone(), is_judged, Rc::clone(&tally));
        check.fences.clone_from(&self.fences);
        Ok(Observed(Subscriber::new(inlet, None, None, check, tally)))
    }
}

/// The messages of one topic, as an observer receives them.
#[derive(Debug)]
pub struct Observed<T: Message>(Subscriber<T>);

impl<T: Message> Observed<T> {
    /// Takes all messages that arrived, in order.
    pub fn drain(&mut self, each: impl FnMut(&T)) -> Result<(), RuntimeError> {
        self.0.drain(u64::MAX, each)
    }

    /// Messages received so far.
    pub fn received(&self) -> ReceivedTopic {
        self.0.tally.borrow().received(T::TOPIC)
    }
}

/// A process that taps a running group: each message as it was sent, unchecked.
#[derive(Debug)]
pub struct Tap(Transport);

impl Tap {
    /// Joins `group` under `name`.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        join(group, name).map(Self)
    }

    /// Taps `T`'s topic from now on.
    pub fn on<T: Message>(&self) -> Result<Tapped<T>, RuntimeError> {
        let inlet = self.0.inlet(Wanted::Every)?;
        Ok(Tapped { held: RefCell::new(inlet.room()), inlet })
    }
}

/// The messages of one topic, as a tap receives them.
#[derive(Debug)]
pub struct Tapped<T: Message> {
    inlet: Inlet<T>,
    held: RefCell<Held<T>>,
}

impl<T: Message> Tapped<T> {
    /// Hands the oldest message that was not yet taken to `each`; false if there is none.
    pub fn take(&self, each: impl FnOnce(&T)) -> Result<bool, RuntimeError> {
        let mut held = self.held.borrow_mut();
        let taken = self.inlet.receive(&mut held);
        let taken = taken.map_err(RuntimeError::topic("receive on", T::TOPIC))?;
        if let (Some(_), Some(message)) = (&taken, held.get()) {
            each(message);
        }
        held.clear();
        Ok(taken.is_some())
    }
}

/// A process that plays recorded messages into a group.
#[derive(Debug)]
pub struct Player(Transport);

impl Player {
    /// Joins `group` under `name`.
    pub fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        join(group, name).map(Self)
    }

    /// Opens the sending end of `T`'s topic.
    pub fn on<T: Message>(&self) -> Result<Played<T>, RuntimeError> {
        let outlet = self.0.outlet(End::default())?;
        Ok(Played { outlet, waker: self.0.waker(T::TOPIC) })
    }
}

/// The sending end of `T`'s topic for messages that are complete.
#[derive(Debug)]
pub struct Played<T: Message> {
    outlet: Outlet<T>,
    waker: Option<Waker>,
}

impl<T: Message> Played<T> {
    /// Sends the message whose bytes these are as it is, and wakes who waits for it.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`], also for as many bytes as no message of the type has.
    pub fn send(&self, bytes: &[u8]) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Topic("send on", T::TOPIC, reason);
        let mut message = self.outlet.loan().map_err(error)?;
        let place = bytemuck::bytes_of_mut(&mut *message);
        if place.len() != bytes.len() {
            return Err(error(TransportError::Length(bytes.len())));
        }
        place.copy_from_slice(bytes);
        self.outlet.send(message).map_err(error)?;
        if let Some(waker) = &self.waker {
            waker.wake();
        }
        Ok(())
    }
}

fn join(group: &Group, name: &str) -> Result<Transport, RuntimeError> {
    SharedMemory::join(group, name).map(Transport::SharedMemory)
}
