//! What carries messages from ports to ports: shared memory between processes, or the memory of one.

mod memory;
mod shared_memory;

pub(super) use memory::{Bus, Seat};
pub use shared_memory::shared_memory_bytes;
pub(super) use shared_memory::{Ipc, SharedMemory};

use super::link::End;
use super::waking::{Waiter, Waker};
use super::{RuntimeError, Timetable};
use messages::{Message, Topic};
use serde::Serialize;
use std::fmt::Debug;
use std::rc::Rc;

/// What carries the messages of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Carrier {
    /// Shared memory, between processes.
    SharedMemory,
    /// The memory of one process, whose only thread the services share.
    Memory,
}

/// Messages that a subscriber can lag behind: twice what the plant publishes between two releases
/// of the slowest service, and enough for half a second without the processor at the usual rates.
fn buffer(timetable: &Timetable) -> usize {
    let slowest = timetable.strides.into_iter().max().unwrap_or(1);
    usize::try_from((2 * slowest + 8).max(50)).expect("strides are small")
}

/// Larger messages have buffers of at most [`LARGE_BUFFER`], bytes: memory for the slowest of many
/// readers would be tens of megabytes.
const LARGE_BYTES: usize = 16 << 10;
const LARGE_BUFFER: usize = 16;

/// The part of `buffer` that `topic` gets.
fn buffer_of(topic: Topic, buffer: usize) -> usize {
    if topic.message_bytes() > LARGE_BYTES { buffer.min(LARGE_BUFFER) } else { buffer }
}

/// An end of a topic that can be connected to all others that exist, ahead of the first message:
/// connecting creates files and allocates.
pub trait Connect: Debug {
    /// Connects.
    fn connect(&self) -> Result<(), String>;
}

/// Sends messages of one type.
pub trait Sender<T>: Connect {
    /// Hands a copy of `message` to all subscribers.
    fn send(&self, message: &T) -> Result<(), String>;
}

/// A sending port, unique on this host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SenderId(u128);

impl SenderId {
    /// Port `number` of a member of a run in one process.
    fn in_process(member: u32, number: u64) -> Self {
        Self(u128::from(member) << 64 | u128::from(number))
    }

    /// The process that made it: iceoryx2's ids are seconds, nanoseconds, process, counter. In one
    /// process, the member.
    pub(super) fn pid(self) -> u32 {
        (self.0 >> 64) as u32
    }
}

/// An end of a topic that messages come out of.
pub trait Input: Debug {
    /// True if a message waits.
    fn has_input(&self) -> bool;
}

/// Receives messages of one type.
pub trait Receiver<T>: Connect + Input {
    /// The oldest message not yet taken, and the port that sent it.
    fn receive(&self) -> Result<Option<(T, SenderId)>, String>;
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

    pub(super) fn waker(&self, topic: Topic) -> Waker {
        match self {
            Self::SharedMemory(node) => node.waker(topic),
            Self::Memory(_) => Waker::InProcess,
        }
    }

    pub(super) fn waiter(&self, topic: Topic) -> Waiter {
        match self {
            Self::SharedMemory(node) => node.waiter(topic),
            Self::Memory(seat) => seat.waiter(),
        }
    }
}
