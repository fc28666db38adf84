//! A message after it arrived: a small one copied, a large one where its sender wrote it.
//!
//! A message of up to [`SMALL_BYTES`] bytes is copied before it is checked. So a faulty sender cannot write
//! into it after the check. A larger one is borrowed: copying the radar's detections would cost more than
//! carrying them. In the memory of one process a message that was sent can be read only, and every one is
//! borrowed.

use super::pooled::PooledIpc as Ipc;
use iceoryx2::sample::Sample;
use messages::{Message, SMALL_BYTES};
use std::rc::Rc;

/// True if messages of type `T` are copied when they arrive.
pub(super) const fn is_copied<T>() -> bool {
    size_of::<T>() <= SMALL_BYTES
}

/// Room for one received message.
#[derive(Debug)]
pub struct Held<T: Message> {
    /// Room for a copy, from the start where messages are copied.
    copy: Option<Box<T>>,
    state: State<T>,
}

#[derive(Debug)]
enum State<T: Message> {
    Empty,
    Copied,
    Sample(Sample<Ipc, T, ()>),
    Memory(Rc<T>),
}

impl<T: Message> Held<T> {
    /// Room without a message.
    pub(crate) fn new() -> Self {
        Self { copy: is_copied::<T>().then(|| Box::new(T::zeroed())), state: State::Empty }
    }

    /// The same of a port whose messages are borrowed, whatever their size.
    pub(super) fn of_borrowed() -> Self {
        Self { copy: None, state: State::Empty }
    }

    /// The message.
    pub(crate) fn get(&self) -> Option<&T> {
        match &self.state {
            State::Empty => None,
            State::Copied => self.copy.as_deref(),
            State::Sample(sample) => Some(sample.payload()),
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
        let Self { copy, state } = self;
        let copy = copy.get_or_insert_with(|| Box::new(T::zeroed()));
        match state {
            State::Empty => return None,
            State::Copied => {}
            State::Sample(sample) => **copy = *sample.payload(),
            State::Memory(message) => **copy = **message,
        }
        *state = State::Copied;
        Some(copy)
    }

    /// Keeps what arrived through shared memory; returns the bytes that were copied for it.
    pub(super) fn take_sample(&mut self, sample: Sample<Ipc, T, ()>) -> usize {
        if is_copied::<T>() {
            self.copy(sample.payload());
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
    #[inline]
    pub(crate) fn clear(&mut self) {
        if !matches!(self.state, State::Empty) {
            self.state = State::Empty;
        }
    }
}

/// The rooms of a port. Their content stays where it is; the rooms change their parts.
#[derive(Debug)]
pub struct Rooms<T: Message> {
    rooms: [Held<T>; 3],
    newest: usize,
    incoming: usize,
    ahead: usize,
}

impl<T: Message> Rooms<T> {
    /// Three rooms as `make` makes them.
    pub(crate) fn new(make: impl Fn() -> Held<T>) -> Self {
        Self { rooms: [make(), make(), make()], newest: 0, incoming: 1, ahead: 2 }
    }

    /// The newest message that was kept.
    pub(crate) fn newest(&self) -> Option<&T> {
        self.rooms[self.newest].get()
    }

    /// The message that is looked at.
    pub(crate) fn incoming(&self) -> &Held<T> {
        &self.rooms[self.incoming]
    }

    /// Room for the message to be looked at.
    pub(crate) fn incoming_mut(&mut self) -> &mut Held<T> {
        &mut self.rooms[self.incoming]
    }

    /// Makes the incoming message the newest.
    pub(crate) fn keep(&mut self) {
        std::mem::swap(&mut self.newest, &mut self.incoming);
        self.incoming_mut().clear();
    }

    /// Puts the incoming message off.
    pub(crate) fn put_off(&mut self) {
        std::mem::swap(&mut self.ahead, &mut self.incoming);
    }

    /// Makes a message that was put off the incoming one; false if there is none.
    pub(crate) fn take_up(&mut self) -> bool {
        if self.rooms[self.ahead].get().is_none() {
            return false;
        }
        self.incoming_mut().clear();
        std::mem::swap(&mut self.ahead, &mut self.incoming);
        true
    }
}
