//! Transport of messages from ports to ports: shared memory between processes, or the memory of one.

pub mod carried;
mod ends;
mod error;
mod held;
mod loan;
mod memory;
mod pooled;
mod shared_memory;
pub mod waking;

pub use ends::{Connect, Input, Receiver, Sealing, Sender, SenderId};
pub use error::TransportError;
pub use held::{Held, Rooms};
pub use loan::Loan;
pub use memory::Turns;
pub(super) use memory::{Bus, Seat};
pub(super) use shared_memory::SharedMemory;
pub use shared_memory::{Ipc, domain, shared_memory_bytes};

use crate::RuntimeError;
use crate::life::link::End;
use crate::transport::waking::{Waiter, Waker};
use messages::{Message, Topic};
use serde::Serialize;
use std::rc::Rc;

/// Carrier of the messages of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Carrier {
    /// Shared memory, between processes.
    SharedMemory,
    /// The memory of one process, whose only thread the services share.
    Memory,
}

/// A member's access to the topics of its run.
#[derive(Debug)]
pub enum Transport {
    /// A process of a group.
    SharedMemory(SharedMemory),
    /// A member of a run in one process.
    Memory(Seat),
}

impl Transport {
    /// Creates the publisher of `T`'s topic. In lockstep it waits while a subscriber's buffer is
    /// full, unless the run was aborted.
    pub(crate) fn publisher<T: Message>(
        &self,
        end: End,
    ) -> Result<Rc<dyn Sender<T>>, RuntimeError> {
        match self {
            Self::SharedMemory(node) => node.publisher(end),
            Self::Memory(seat) => Ok(seat.publisher(end)),
        }
    }

    pub(crate) fn subscriber<T: Message>(&self) -> Result<Rc<dyn Receiver<T>>, RuntimeError> {
        match self {
            Self::SharedMemory(node) => node.subscriber(),
            Self::Memory(seat) => Ok(seat.subscriber()),
        }
    }

    /// Removes what dead processes left on the topics.
    pub(super) fn remove_dead(&self) {
        match self {
            Self::SharedMemory(node) => node.remove_dead(),
            // Members of one process end together.
            Self::Memory(_) => {}
        }
    }

    /// Wakes those who wait for a topic; `None` in one thread, in which services wait for their turn.
    pub(super) fn waker(&self, topic: Topic) -> Option<Waker> {
        match self {
            Self::SharedMemory(node) => Some(node.waker(topic)),
            Self::Memory(_) => None,
        }
    }

    pub(super) fn waiter(&self, topic: Topic) -> Waiter {
        match self {
            Self::SharedMemory(node) => node.waiter(topic),
            Self::Memory(seat) => seat.waiter(),
        }
    }
}
