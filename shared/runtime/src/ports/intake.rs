//! Way from a topic to the check: the messages of the group, one by one.
//!
//! A receiving end is built of stages. Each stage hands its messages to the next one:
//!
//! ```text
//! Wire: senders, losses ─► (decorator: disturbed channel) ─► Checks: fence, end-to-end, clock ─► newest
//! ```

use super::tally::Tally;
use crate::RuntimeError;
use crate::ports::members::Members;
use crate::transport::{Receiver, Rooms, SenderId};
use messages::{Header, Message, Service};
use std::cell::RefCell;
use std::fmt::Debug;
use std::rc::Rc;

/// Senders that a port keeps. A group restarts its services less often than that in any while.
const REMEMBERED_SENDERS: usize = 16;

/// The next stage: takes the incoming message of the rooms, and returns true if it keeps the message.
pub(crate) type Next<'a, T> = &'a mut dyn FnMut(&mut Rooms<T>) -> bool;

/// A stage that messages come out of.
pub(crate) trait Intake<T: Message>: Debug {
    /// Takes all messages of up to `step`, in order, into the incoming room and hands them to `next`.
    fn drain(
        &mut self,
        step: u64,
        rooms: &mut Rooms<T>,
        next: Next<'_, T>,
    ) -> Result<(), RuntimeError>;

    /// Newest step of which a message arrived, whatever became of it.
    fn arrived_step(&self) -> Option<u64>;

    /// Learns which message the reader has, after it took all that were due.
    fn settled(&self, _newest: Option<&T>, _now_ns: i64) {}
}

/// The topic itself: refuses unknown senders and counts what was lost.
#[derive(Debug)]
pub(crate) struct Wire<T: Message> {
    port: Rc<dyn Receiver<T>>,
    arrived_step: Option<u64>,
    /// Incarnation and sequence number of the last message of each source.
    last: [(u32, u64); Service::ALL.len() + 1],
    members: Rc<Members>,
    /// Senders that were looked up, and whether they belong to the group.
    senders: [Option<(SenderId, bool)>; REMEMBERED_SENDERS],
    next_sender: usize,
    tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Wire<T> {
    pub(crate) fn new(
        port: Rc<dyn Receiver<T>>,
        members: Rc<Members>,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        Self {
            port,
            arrived_step: None,
            last: [(0, 0); Service::ALL.len() + 1],
            members,
            senders: [None; REMEMBERED_SENDERS],
            next_sender: 0,
            tally,
        }
    }

    /// Takes the next message of a member of the group; false if there is none.
    fn receive(&mut self, rooms: &mut Rooms<T>) -> Result<bool, RuntimeError> {
        loop {
            rooms.incoming_mut().clear();
            let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
            let Some(arrival) = self.port.receive(rooms.incoming_mut()).map_err(error)? else {
                return Ok(false);
            };
            let Some(sample) = rooms.incoming().get() else { return Ok(false) };
            let &Header { source, incarnation, sequence, .. } = sample.header();
            if !self.knows(arrival.sender, source, incarnation) {
                self.tally.borrow_mut().e2e.unknown_sender += 1;
                continue;
            }
            let mut tally = self.tally.borrow_mut();
            if let Some(last) = self.last.get_mut(source as usize) {
                // A new incarnation counts from 1 again; the first sample of a late joiner is not a loss.
                if last.0 == incarnation && last.1 > 0 {
                    tally.lost += sequence.saturating_sub(last.1 + 1);
                }
                *last = (incarnation, sequence);
            }
            tally.copied_bytes += arrival.copied_bytes as u64;
            tally.messages += 1;
            return Ok(true);
        }
    }

    /// True if `sender` is the process that the header names.
    fn knows(&mut self, sender: SenderId, source: u32, incarnation: u32) -> bool {
        if let Some((_, belongs)) = self.senders.iter().flatten().find(|(id, _)| *id == sender) {
            return *belongs;
        }
        let sources = T::TOPIC.sources();
        let allowed =
            sources.is_empty() || sources.iter().any(|service| service.to_wire() == source);
        let belongs = allowed && self.members.is_member(source, incarnation, sender.pid());
        self.senders[self.next_sender] = Some((sender, belongs));
        self.next_sender = (self.next_sender + 1) % REMEMBERED_SENDERS;
        belongs
    }
}

impl<T: Message> Intake<T> for Wire<T> {
    fn drain(
        &mut self,
        step: u64,
        rooms: &mut Rooms<T>,
        next: Next<'_, T>,
    ) -> Result<(), RuntimeError> {
        while rooms.take_up() || self.receive(rooms)? {
            let Some(sample) = rooms.incoming().get() else { break };
            // The check refuses a wrong step; the wait for it must end.
            let of_step = sample.header().step;
            if of_step > step {
                rooms.put_off();
                break;
            }
            self.arrived_step = self.arrived_step.max(Some(of_step));
            next(rooms);
        }
        Ok(())
    }

    fn arrived_step(&self) -> Option<u64> {
        self.arrived_step
    }
}
