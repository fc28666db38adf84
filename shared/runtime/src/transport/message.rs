//! A message while it is written and after it arrived.
//!
//! It is written where its readers will read it. A message of up to [`SMALL_BYTES`] bytes is copied before it is
//! checked. So a faulty sender cannot write into it after the check. A larger one is borrowed: copying the radar's
//! detections would cost more than carrying them. In the memory of one process a message that was sent can be read
//! only, and every one is borrowed.

#![allow(unsafe_code, reason = "iceoryx2 carries the bytes of a message, whatever its type")]

use super::shared_memory::{LoanedSample, Payload, ReceivedSample};
use bytemuck::{cast_slice, cast_slice_mut, from_bytes, from_bytes_mut};
use messages::{Message, SMALL_BYTES};
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

/// A message in the memory of the process: its bytes as words, which have the alignment of each message.
pub(super) type Words = Rc<[u64]>;

/// Memory for one message, loaned from the port that will send it. A loan that is not sent goes back to
/// its port.
#[derive(Debug)]
pub struct Loan<T: Message>(pub(crate) Place, PhantomData<T>);

#[derive(Debug)]
pub(crate) enum Place {
    /// In the sender's segment of shared memory.
    SharedMemory(LoanedSample),
    /// In the memory of the process; there is no other handle until it is sent.
    Memory(Words),
}

impl Place {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::SharedMemory(sample) => bytes_in(sample.payload()),
            Self::Memory(words) => cast_slice(words),
        }
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        match self {
            Self::SharedMemory(sample) => {
                let payload = sample.payload_mut();
                // SAFETY: as in `bytes_in`, and the payload is borrowed for as long as the bytes.
                unsafe {
                    std::slice::from_raw_parts_mut(payload.as_mut_ptr().cast(), payload.len())
                }
            }
            Self::Memory(words) => {
                cast_slice_mut(Rc::get_mut(words).expect("not sent yet: no other handle"))
            }
        }
    }
}

impl<T: Message> Loan<T> {
    pub(crate) fn at(place: Place) -> Self {
        Self(place, PhantomData)
    }
}

fn bytes_in(payload: &Payload) -> &[u8] {
    // SAFETY: a payload is bytes, whose type iceoryx2 leaves open.
    unsafe { std::slice::from_raw_parts(payload.as_ptr().cast(), payload.len()) }
}

impl<T: Message> Deref for Loan<T> {
    type Target = T;

    fn deref(&self) -> &T {
        from_bytes(self.0.bytes())
    }
}

impl<T: Message> DerefMut for Loan<T> {
    fn deref_mut(&mut self) -> &mut T {
        from_bytes_mut(self.0.bytes_mut())
    }
}

/// A message that arrived, in the memory of its sender.
#[derive(Debug)]
pub(crate) enum Taken {
    Sample(ReceivedSample),
    Memory(Words),
}

impl Taken {
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Sample(sample) => bytes_in(sample.payload()),
            Self::Memory(words) => cast_slice(words),
        }
    }
}

/// Room for one received message.
#[derive(Debug)]
pub(crate) struct Held<T: Message> {
    /// Room for a copy, from the start where messages are copied.
    copy: Option<Box<T>>,
    state: State,
}

#[derive(Debug)]
enum State {
    Empty,
    Copied,
    Borrowed(Taken),
}

impl<T: Message> Held<T> {
    /// True if messages of the type are copied when they arrive through shared memory.
    const IS_COPIED: bool = size_of::<T>() <= SMALL_BYTES;

    /// Room without a message, for one that comes through shared memory or not.
    pub(super) fn new(is_shared: bool) -> Self {
        let copy = (is_shared && Self::IS_COPIED).then(|| Box::new(T::zeroed()));
        Self { copy, state: State::Empty }
    }

    pub(crate) fn get(&self) -> Option<&T> {
        match &self.state {
            State::Empty => None,
            State::Copied => self.copy.as_deref(),
            State::Borrowed(taken) => Some(from_bytes(taken.bytes())),
        }
    }

    pub(crate) fn copy(&mut self, message: &T) {
        **self.copy.get_or_insert_with(|| Box::new(T::zeroed())) = *message;
        self.state = State::Copied;
    }

    /// The message as a copy of the reader's own, which it may change.
    pub(crate) fn own(&mut self) -> Option<&mut T> {
        match std::mem::replace(&mut self.state, State::Empty) {
            State::Empty => return None,
            State::Copied => self.state = State::Copied,
            State::Borrowed(taken) => self.copy(from_bytes(taken.bytes())),
        }
        self.copy.as_deref_mut()
    }

    /// Keeps what arrived.
    pub(crate) fn take(&mut self, taken: Taken) {
        match taken {
            Taken::Sample(_) if Self::IS_COPIED => self.copy(from_bytes(taken.bytes())),
            _ => self.state = State::Borrowed(taken),
        }
    }

    /// Gives the message back to its sender.
    pub(crate) fn clear(&mut self) {
        self.state = State::Empty;
    }
}
