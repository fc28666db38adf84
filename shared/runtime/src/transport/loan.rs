//! A message while it is written, where its readers will read it.

use super::pooled::PooledIpc as Ipc;
use iceoryx2::sample_mut::SampleMut;
use messages::Message;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

/// Memory for one message, loaned from the port that will send it. A loan that is not sent goes back to
/// its port.
#[derive(Debug)]
pub struct Loan<T: Message>(pub(super) Place<T>);

/// Place of a loaned message.
#[derive(Debug)]
pub(super) enum Place<T: Message> {
    /// In the sender's segment of shared memory.
    SharedMemory(SampleMut<Ipc, T, ()>),
    /// In the memory of the process; there is no other handle until it is sent.
    Memory(Rc<T>),
}

impl<T: Message> Deref for Loan<T> {
    type Target = T;

    fn deref(&self) -> &T {
        match &self.0 {
            Place::SharedMemory(sample) => sample.payload(),
            Place::Memory(message) => message,
        }
    }
}

impl<T: Message> DerefMut for Loan<T> {
    fn deref_mut(&mut self) -> &mut T {
        match &mut self.0 {
            Place::SharedMemory(sample) => sample.payload_mut(),
            Place::Memory(message) => Rc::get_mut(message).expect("not sent yet: no other handle"),
        }
    }
}
