//! Carriers of messages: shared memory between processes, or the memory of one.
//!
//! ```text
//! Outlet ─► shared memory: a port of iceoryx2 for bytes of any layout ─────────────────────► Inlet
//!        └► memory: the topic's newest message, and queues for who needs each of them ────┘
//! ```

mod memory;
mod message;
mod pooled;
mod shared_memory;
pub mod waking;

pub use memory::Turns;
pub(super) use memory::{Bus, Seat};
pub(super) use message::Held;
pub use message::Loan;
pub use shared_memory::{Ipc, domain, shared_memory_bytes};
pub(super) use shared_memory::{Receiver, Sender, SenderId, SharedMemory};

use crate::life::link::End;
use crate::transport::memory::{MemoryReceiver, MemorySender};
use crate::transport::message::Place;
use crate::transport::waking::{Waiter, Waker};
use crate::{Clock, RuntimeError, Timetable, TransportError};
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

/// Sealing of messages: their CRC, and their place in digests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sealing {
    /// They do, as between processes.
    #[default]
    Sealed,
    /// They do not: nothing outside of the run's thread ever has them, and nothing compares them with another
    /// run's. All else is the same.
    Unsealed,
}

/// Messages that a subscriber can lag behind. They are twice what the plant publishes between two releases of
/// the slowest service. At the usual rates they last for half a second without the processor.
fn buffer(timetable: &Timetable) -> usize {
    let slowest = timetable.strides.into_iter().max().unwrap_or(1);
    usize::try_from((2 * slowest + 8).max(50)).expect("strides are small")
}

/// Larger messages have buffers of at most [`LARGE_BUFFER`], bytes. Memory for the slowest of many readers would be
/// tens of megabytes.
const LARGE_BYTES: usize = 16 << 10;
const LARGE_BUFFER: usize = 16;

/// The part of `buffer` that `topic` gets.
fn buffer_of(topic: Topic, buffer: usize) -> usize {
    if topic.message_bytes() > LARGE_BYTES { buffer.min(LARGE_BUFFER) } else { buffer }
}

/// A member's access to the topics of its run.
#[derive(Debug)]
pub(crate) enum Transport {
    /// A process of a group.
    SharedMemory(SharedMemory),
    /// A member of a run in one process.
    Memory(Seat),
}

impl Transport {
    pub(crate) fn carrier(&self) -> Carrier {
        match self {
            Self::SharedMemory(_) => Carrier::SharedMemory,
            Self::Memory(_) => Carrier::Memory,
        }
    }

    pub(crate) fn sealing(&self) -> Sealing {
        match self {
            Self::SharedMemory(_) => Sealing::Sealed,
            Self::Memory(seat) => seat.bus.sealing,
        }
    }

    /// Creates the sending end of `T`'s topic. In lockstep it waits while a receiver has no room, unless the run was
    /// aborted.
    pub(crate) fn outlet<T: Message>(&self, end: End) -> Result<Outlet<T>, RuntimeError> {
        Ok(match self {
            Self::SharedMemory(node) => Outlet::SharedMemory(Rc::new(node.sender(T::TOPIC, end)?)),
            Self::Memory(seat) => Outlet::Memory(seat.sender(end)),
        })
    }

    /// Creates a receiving end of `T`'s topic.
    pub(crate) fn inlet<T: Message>(&self, wanted: Wanted<'_>) -> Result<Inlet<T>, RuntimeError> {
        Ok(match self {
            Self::SharedMemory(node) => Inlet::SharedMemory(Rc::new(node.receiver(T::TOPIC)?)),
            Self::Memory(seat) => Inlet::Memory(seat.receiver(wanted)),
        })
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

/// The messages of a topic that a reader in memory needs. Shared memory brings each of them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted<'a> {
    Every,
    /// The newest one at each release of a service, whose clock this is.
    Newest(&'a Rc<Clock>),
}

/// The sending end of a topic.
#[derive(Debug)]
pub(crate) enum Outlet<T: Message> {
    SharedMemory(Rc<Sender>),
    Memory(MemorySender<T>),
}

impl<T: Message> Outlet<T> {
    /// Memory for a message where its readers will read it. It holds zeros or an earlier message of this
    /// port.
    pub(crate) fn loan(&self) -> Result<Loan<T>, TransportError> {
        Ok(match self {
            Self::SharedMemory(port) => Loan(Place::SharedMemory(port.loan()?)),
            Self::Memory(port) => Loan(Place::Memory(port.loan())),
        })
    }

    /// Hands a message that was loaned here to all receivers.
    pub(crate) fn send(&self, message: Loan<T>) -> Result<(), TransportError> {
        match (self, message.0) {
            (Self::SharedMemory(_), Place::SharedMemory(sample)) => {
                sample.send().map(|_| ()).map_err(TransportError::iceoryx2)
            }
            (Self::Memory(port), Place::Memory(message)) => port.send(message),
            _ => Err(TransportError::OtherCarrier),
        }
    }
}

/// A receiving end of a topic.
#[derive(Debug)]
pub(crate) enum Inlet<T: Message> {
    SharedMemory(Rc<Receiver>),
    Memory(MemoryReceiver<T>),
}

/// A message that was taken from a topic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    /// The port that sent it; `None` in the memory of one process, in which each sender is known.
    pub(crate) sender: Option<SenderId>,
    /// Messages since the last look, of which this is the newest.
    pub(crate) messages: u64,
    /// Bytes that were copied to take it.
    pub(crate) copied_bytes: usize,
}

impl<T: Message> Inlet<T> {
    /// Room for one message.
    pub(crate) fn room(&self) -> Held<T> {
        Held::new(matches!(self, Self::SharedMemory(_)))
    }

    /// Takes the next message into `held`; `None` if there is none.
    pub(crate) fn receive(&self, held: &mut Held<T>) -> Result<Option<Arrival>, TransportError> {
        match self {
            Self::SharedMemory(port) => Ok(port.receive()?.map(|sample| {
                let sender = Some(SenderId::of_port(sample.origin().value()));
                Arrival { sender, messages: 1, copied_bytes: held.take_sample(sample) }
            })),
            Self::Memory(port) => Ok(port.receive().map(|(message, messages)| {
                held.take_shared(message);
                Arrival { sender: None, messages, copied_bytes: 0 }
            })),
        }
    }
}
