//! A message while it is written and after it arrived.
//!
//! It is written where its readers will read it. A message of up to [`SMALL_BYTES`] bytes is copied before it is
//! checked. So a faulty sender cannot write into it after the check. A larger one is borrowed: copying the radar's
//! detections would cost more than carrying them. In the memory of one process a message that was sent can be read
//! only, and every one is borrowed.

#![allow(unsafe_code, reason = "iceoryx2 carries the bytes of a message, whatever its type")]

use super::shared_memory::{LoanedSample, Payload, ReceivedSample};
use messages::{Message, SMALL_BYTES};
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

/// Memory for one message, loaned from the port that will send it. A loan that is not sent goes back to
/// its port.
#[derive(Debug)]
pub struct Loan<T: Message>(pub(super) Place<T>);

#[derive(Debug)]
pub(super) enum Place<T: Message> {
    /// In the sender's segment of shared memory.
    SharedMemory(LoanedSample),
    /// In the memory of the process; there is no other handle until it is sent.
    Memory(Rc<T>),
}

fn message_in<T: Message>(payload: &Payload) -> &T {
    assert_eq!(payload.len(), size_of::<T>(), "a topic has one message type");
    // SAFETY: there are as many bytes as a `T` has, which is `Pod`. The topic was opened with the alignment of a `T`.
    unsafe { &*payload.as_ptr().cast() }
}

impl<T: Message> Deref for Loan<T> {
    type Target = T;

    fn deref(&self) -> &T {
        match &self.0 {
            Place::SharedMemory(sample) => message_in(sample.payload()),
            Place::Memory(message) => message,
        }
    }
}

impl<T: Message> DerefMut for Loan<T> {
    fn deref_mut(&mut self) -> &mut T {
        match &mut self.0 {
            Place::SharedMemory(sample) => {
                let payload = sample.payload_mut();
                assert_eq!(payload.len(), size_of::<T>(), "a topic has one message type");
                // SAFETY: as in `message_in`, and the payload is borrowed for as long as the message.
                unsafe { &mut *payload.as_mut_ptr().cast() }
            }
            Place::Memory(message) => Rc::get_mut(message).expect("not sent yet: no other handle"),
        }
    }
}

/// Room for one received message.
#[derive(Debug)]
pub(crate) struct Held<T: Message> {
    /// Room for a copy, from the start where messages are copied.
    copy: Option<Box<T>>,
    state: State<T>,
}

#[derive(Debug)]
enum State<T: Message> {
    Empty,
    Copied,
    Sample(ReceivedSample),
    Memory(Rc<T>),
}

impl<T: Message> Held<T> {
    /// True if messages of the type are copied when they arrive through shared memory.
    const IS_COPIED: bool = size_of::<T>() <= SMALL_BYTES;

    /// Room without a message, for one that comes through shared memory or not.
    pub(crate) fn new(is_shared: bool) -> Self {
        let copy = (is_shared && Self::IS_COPIED).then(|| Box::new(T::zeroed()));
        Self { copy, state: State::Empty }
    }

    pub(crate) fn get(&self) -> Option<&T> {
        match &self.state {
            State::Empty => None,
            State::Copied => self.copy.as_deref(),
            State::Sample(sample) => Some(message_in(sample.payload())),
            State::Memory(message) => Some(message),
        }
    }

    /// Keeps a copy of `message`.
    pub(crate) fn copy(&mut self, message: &T) {
        **self.copy.get_or_insert_with(|| Box::new(T::zeroed())) = *message;
        self.state = State::Copied;
    }

    /// The message as a copy of the reader's own, which it may change.
    pub(crate) fn own(&mut self) -> Option<&mut T> {
        match std::mem::replace(&mut self.state, State::Empty) {
            State::Empty => return None,
            State::Copied => self.state = State::Copied,
            State::Sample(sample) => self.copy(message_in(sample.payload())),
            State::Memory(message) => self.copy(&message),
        }
        self.copy.as_deref_mut()
    }

    /// Keeps what arrived through shared memory; returns the bytes that were copied for it.
    pub(super) fn take_sample(&mut self, sample: ReceivedSample) -> usize {
        if Self::IS_COPIED {
            self.copy(message_in(sample.payload()));
            return size_of::<T>();
        }
        self.state = State::Sample(sample);
        0
    }

    /// Keeps what arrived in the memory of the process.
    pub(super) fn take_shared(&mut self, message: Rc<T>) {
        self.state = State::Memory(message);
    }

    /// True if no other code could write to the message since its sender handed it over.
    pub(crate) fn is_as_sent(&self) -> bool {
        matches!(self.state, State::Memory(_))
    }

    /// Gives the message back to its sender.
    pub(crate) fn clear(&mut self) {
        self.state = State::Empty;
    }
}
