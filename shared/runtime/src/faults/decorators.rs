//! Faults around the ports: a stage of a receiving end and a stage of a sending end.

use super::activation::Faults;
use super::channel::ChannelFaults;
use super::sender::SenderFaults;
use crate::ports::{Intake, Next, Outgoing};
use crate::transport::{Loan, Rooms, Sealing};
use crate::{Clock, RuntimeError};
use messages::{Drive, EgoTruth, Message, Topic};
use std::rc::Rc;

/// A disturbed channel behind `inner`.
#[derive(Debug)]
pub(crate) struct Disturbed<T: Message, I> {
    inner: I,
    sealing: Sealing,
    faults: Rc<Faults>,
    clock: Rc<Clock>,
    /// Made for the first fault.
    channel: Option<Box<ChannelFaults<T>>>,
}

impl<T: Message, I: Intake<T>> Disturbed<T, I> {
    /// Lets `faults` disturb what comes out of `inner`, a topic of messages sealed so.
    pub(crate) fn new(inner: I, sealing: Sealing, faults: Rc<Faults>, clock: Rc<Clock>) -> Self {
        Self { inner, sealing, faults, clock, channel: None }
    }
}

impl<T: Message, I: Intake<T>> Intake<T> for Disturbed<T, I> {
    fn drain(
        &mut self,
        step: u64,
        rooms: &mut Rooms<T>,
        next: Next<'_, T>,
    ) -> Result<(), RuntimeError> {
        let Self { inner, sealing, faults, clock, channel } = self;
        inner.drain(step, rooms, &mut |rooms| {
            if !faults.disturbs(T::TOPIC) {
                return next(rooms);
            }
            let channel = channel.get_or_insert_with(|| Box::new(ChannelFaults::new()));
            let Some(message) = rooms.incoming().get() else { return false };
            channel.take(message, *sealing, faults, clock.now_ns()) && next(rooms)
        })?;
        let Some(channel) = channel else { return Ok(()) };
        let now_ns = clock.now_ns();
        while let Some(disturbed) = channel.hand_over(now_ns) {
            rooms.incoming_mut().copy(&disturbed.message);
            let passed = next(rooms);
            if let Some(number) = disturbed.corrupted_by.filter(|_| passed) {
                faults.went_undetected(number);
            }
        }
        Ok(())
    }

    fn arrived_step(&self) -> Option<u64> {
        self.inner.arrived_step()
    }

    fn settled(&self, newest: Option<&T>, now_ns: i64) {
        self.inner.settled(newest, now_ns);
        self.faults.observe(|| newest.and_then(drive), now_ns);
    }
}

/// A sender with false content before `inner`.
#[derive(Debug)]
pub(crate) struct Falsified<T, O> {
    inner: O,
    faults: Rc<Faults>,
    content: SenderFaults<T>,
}

impl<T: Message, O: Outgoing<T>> Falsified<T, O> {
    /// Lets `faults` change what goes into `inner`.
    pub(crate) fn new(inner: O, faults: Rc<Faults>) -> Self {
        Self { inner, faults, content: SenderFaults::new() }
    }
}

impl<T: Message, O: Outgoing<T>> Outgoing<T> for Falsified<T, O> {
    fn send(&mut self, mut message: Loan<T>) -> Result<(), RuntimeError> {
        let now_ns = message.header().publish_ns;
        self.faults.observe(|| drive(&*message), now_ns);
        if self.faults.falsifies(T::TOPIC) {
            self.content.apply(&mut message, &self.faults, now_ns);
        }
        self.inner.send(message)
    }
}

/// State of the drive in a message of the ego's ground truth: what faults can wait for.
fn drive<T: Message>(message: &T) -> Option<Drive> {
    (T::TOPIC == Topic::EgoTruth)
        .then(|| Drive::of(bytemuck::from_bytes::<EgoTruth>(bytemuck::bytes_of(message))))
}
