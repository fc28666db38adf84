//! Interface of all carriers: ends of topics that connect, send and receive.

use super::error::TransportError;
use super::held::Held;
use super::loan::Loan;
use crate::Timetable;
use messages::{Message, Topic};
use std::fmt::Debug;

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
pub(super) fn buffer(timetable: &Timetable) -> usize {
    let slowest = timetable.strides.into_iter().max().unwrap_or(1);
    usize::try_from((2 * slowest + 8).max(50)).expect("strides are small")
}

/// Larger messages have buffers of at most [`LARGE_BUFFER`], bytes. Memory for the slowest of many readers would be
/// tens of megabytes.
const LARGE_BYTES: usize = 16 << 10;
const LARGE_BUFFER: usize = 16;

/// The part of `buffer` that `topic` gets.
pub(super) fn buffer_of(topic: Topic, buffer: usize) -> usize {
    if topic.message_bytes() > LARGE_BYTES { buffer.min(LARGE_BUFFER) } else { buffer }
}

/// An end of a topic that can be connected to all existing others, ahead of the first message. Connecting creates files
/// and allocates.
pub trait Connect: Debug {
    /// Connects.
    fn connect(&self) -> Result<(), TransportError>;
}

/// Sends messages of one type.
pub trait Sender<T: Message>: Connect {
    /// Memory for a message where its readers will read it. It holds zeros or an earlier message of this
    /// port.
    fn loan(&self) -> Result<Loan<T>, TransportError>;

    /// Hands a message that was loaned here to all subscribers.
    fn send(&self, message: Loan<T>) -> Result<(), TransportError>;

    /// The sealing of messages.
    fn sealing(&self) -> Sealing {
        Sealing::Sealed
    }
}

/// A sending port, unique on this host: the high and the low half of 128 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SenderId(u64, u64);

impl SenderId {
    /// Port `id` of iceoryx2.
    pub(super) fn of_port(id: u128) -> Self {
        Self((id >> 64) as u64, id as u64)
    }

    /// Port `number` of a member of a run in one process.
    pub(super) fn in_process(member: u32, number: u64) -> Self {
        Self(u64::from(member), number)
    }

    /// The process that made it: iceoryx2's ids are seconds, nanoseconds, process, counter. In one
    /// process, the member.
    pub(crate) fn pid(self) -> u32 {
        self.0 as u32
    }
}

/// An end of a topic that messages come out of.
pub trait Input: Debug {
    /// True if a message waits.
    fn has_input(&self) -> bool;
}

/// A message that was taken from a topic.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The port that sent it.
    pub(crate) sender: SenderId,
    /// Bytes that were copied to take it.
    pub(crate) copied_bytes: usize,
}

/// Receives messages of one type.
pub trait Receiver<T: Message>: Connect + Input {
    /// Room for one message.
    fn room(&self) -> Held<T> {
        Held::new()
    }

    /// Takes the oldest message not yet taken into `held`.
    fn receive(&self, held: &mut Held<T>) -> Result<Option<Arrival>, TransportError>;

    /// True if the messages carry their CRC.
    fn sealing(&self) -> Sealing {
        Sealing::Sealed
    }
}
