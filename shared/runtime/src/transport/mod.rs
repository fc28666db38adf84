//! Carriers of messages: shared memory between processes, or the memory of one.
//!
//! ```text
//! Sender ─► shared memory: a port of iceoryx2 for bytes of any layout ─────────────────────► Receiver
//!        └► memory: the topic's newest message, and queues for who needs each of them ────┘
//! ```

mod memory;
mod message;
mod pooled;
mod shared_memory;
pub mod waking;

pub use memory::Turns;
pub(super) use memory::{Bus, Seat};
pub use message::Loan;
pub(super) use message::{Held, Place, Taken};
pub(super) use shared_memory::SharedMemory;
pub use shared_memory::{Ipc, shared_memory_bytes};

use crate::life::link::End;
use crate::survival::fence::Peers;
use crate::transport::memory::{MemoryReceiver, MemorySender};
use crate::transport::shared_memory::{ReceivingPort, SendingPort, loan, pid_of};
use crate::transport::waking::{Waiter, Waker};
use crate::{Clock, RuntimeError, Timetable, TransportError};
use iceoryx2::port::update_connections::UpdateConnections;
use messages::{Message, Topic};
use serde::Serialize;
use std::rc::Rc;

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
    /// Each message is sealed, as between processes.
    #[default]
    Sealed,
    /// Only messages on which a fault can act are sealed. Nothing outside of the run's thread ever has the others, and
    /// nothing compares them with another run's. All else is the same.
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
    SharedMemory(SharedMemory),
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

    /// The other processes; `None` in one process, in which each sender is known.
    pub(crate) fn peers(&self) -> Option<&Peers> {
        match self {
            Self::SharedMemory(node) => Some(&node.peers),
            Self::Memory(_) => None,
        }
    }

    /// Creates the sending end of `topic`. In lockstep it waits while a receiver has no room, unless the run was
    /// aborted.
    pub(crate) fn sender(&self, topic: Topic, end: End) -> Result<Rc<Sender>, RuntimeError> {
        Ok(Rc::new(match self {
            Self::SharedMemory(node) => Sender::SharedMemory(node.sender(topic, end)?),
            Self::Memory(seat) => Sender::Memory(seat.sender(topic, end)),
        }))
    }

    pub(crate) fn receiver(
        &self,
        topic: Topic,
        wanted: Wanted<'_>,
    ) -> Result<Rc<Receiver>, RuntimeError> {
        Ok(Rc::new(match self {
            Self::SharedMemory(node) => Receiver::SharedMemory(node.receiver(topic)?),
            Self::Memory(seat) => Receiver::Memory(seat.receiver(topic, wanted)),
        }))
    }

    /// Removes what dead processes left on the topics. Members of one process end together.
    pub(super) fn remove_dead(&self) {
        if let Self::SharedMemory(node) = self {
            node.remove_dead();
        }
    }

    /// Wakes those who wait for a topic; `None` in one thread, in which services wait for their turn.
    pub(super) fn waker(&self, topic: Topic) -> Option<Waker> {
        self.peers().map(|peers| Waker::new(&peers.words, topic))
    }

    pub(super) fn waiter(&self, topic: Topic) -> Waiter {
        match self {
            Self::SharedMemory(node) => Waiter::Futex(Waker::new(&node.peers.words, topic)),
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

#[derive(Debug)]
pub(crate) enum Sender {
    SharedMemory(SendingPort),
    Memory(MemorySender),
}

impl Sender {
    /// Connects to the receivers that exist, ahead of the first message: it creates files and allocates.
    pub(crate) fn connect(&self) -> Result<(), TransportError> {
        match self {
            Self::SharedMemory(port) => port.update_connections().map_err(TransportError::iceoryx2),
            Self::Memory(_) => Ok(()),
        }
    }

    /// Memory for a message where its readers will read it. It holds zeros or an earlier message of this
    /// port.
    pub(crate) fn loan(&self) -> Result<Place, TransportError> {
        Ok(match self {
            Self::SharedMemory(port) => Place::SharedMemory(loan(port)?),
            Self::Memory(port) => Place::Memory(port.loan()),
        })
    }

    /// Hands a message of `step` that was loaned here to all receivers.
    pub(crate) fn send(&self, message: Place, step: u64) -> Result<(), TransportError> {
        match (self, message) {
            (_, Place::SharedMemory(sample)) => {
                sample.send().map(|_| ()).map_err(TransportError::iceoryx2)
            }
            (Self::Memory(port), Place::Memory(words)) => port.send(words, step),
            _ => Err(TransportError::Refused("a message of another carrier")),
        }
    }
}

#[derive(Debug)]
pub(crate) enum Receiver {
    SharedMemory(ReceivingPort),
    Memory(MemoryReceiver),
}

/// A message that was taken from a topic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    /// Process whose port sent it; `None` in the memory of one process, in which each sender is known.
    pub(crate) pid: Option<u32>,
    /// Messages since the last look, of which this is the newest.
    pub(crate) messages: u64,
}

impl Receiver {
    pub(crate) fn connect(&self) -> Result<(), TransportError> {
        match self {
            Self::SharedMemory(port) => port.update_connections().map_err(TransportError::iceoryx2),
            Self::Memory(_) => Ok(()),
        }
    }

    /// True if a message waits, also where none has to be waited for.
    pub(crate) fn has_input(&self) -> bool {
        match self {
            Self::SharedMemory(port) => port.has_samples().unwrap_or(false),
            Self::Memory(_) => true,
        }
    }

    pub(crate) fn room<T: Message>(&self) -> Held<T> {
        Held::new(matches!(self, Self::SharedMemory(_)))
    }

    /// Takes the next message; `None` if there is none.
    pub(crate) fn receive(&self) -> Result<Option<(Taken, Arrival)>, TransportError> {
        match self {
            Self::SharedMemory(port) => {
                let sample = port.receive().map_err(TransportError::iceoryx2)?;
                Ok(sample.map(|sample| {
                    let pid = Some(pid_of(sample.origin().value()));
                    (Taken::Sample(sample), Arrival { pid, messages: 1 })
                }))
            }
            Self::Memory(port) => Ok(port
                .receive()
                .map(|(words, messages)| (Taken::Memory(words), Arrival { pid: None, messages }))),
        }
    }
}
