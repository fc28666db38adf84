//! The receiving end of a topic.

use super::tally::Tally;
use crate::faults::{ChannelFaults, Faults};
use crate::life::link::End;
use crate::ports::members::Members;
use crate::survival::fence::Fences;
use crate::transport::waking::{Ticket, Waiter};
use crate::transport::{Receiver, Rooms, SenderId, TransportError};
use crate::{Clock, RuntimeError};
use messages::e2e::{Channel, profile7};
use messages::{Header, Message, Origin, Service};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Senders that a port remembers; a group restarts its services less often than that in any while.
const REMEMBERED_SENDERS: usize = 16;
/// A stamp may be so far ahead of the reader's clock: both are one clock of one host, read one after
/// the other, ns.
const FUTURE_TOLERANCE_NS: i64 = 5_000_000;
/// Periods of its source after which a topic without a message counts as silent.
const SILENCE: f64 = 1.5;

/// How often messages of a topic are expected in a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// The service that sends them.
    pub(crate) source: Service,
    /// Steps between two of its releases.
    pub(crate) stride: u64,
    /// Time between two messages, ns.
    pub(crate) period_ns: i64,
}

/// The receiving end of `T`'s topic: keeps the newest sample that passed the end-to-end check and is
/// not of a later step.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    port: Rc<dyn Receiver<T>>,
    waiter: Option<Waiter>,
    /// The newest sample, the one that is looked at, and one of a later step than the reader's.
    rooms: Rooms<T>,
    /// Newest step of which a message arrived, whatever the check made of it.
    arrived_step: Option<u64>,
    /// Incarnation and sequence number of the last message of each source.
    last: [(u32, u64); Service::ALL.len() + 1],
    channels: [Channel; Service::ALL.len() + 1],
    members: Rc<Members>,
    /// Who may speak for the services that have a standby.
    fences: Option<Fences>,
    /// Senders that were looked up, and whether they belong to the group.
    senders: [Option<(SenderId, bool)>; REMEMBERED_SENDERS],
    next_sender: usize,
    /// None for an observer, who has no part in the run's time.
    clock: Option<Rc<Clock>>,
    faults: Rc<Faults>,
    channel_faults: Option<Box<ChannelFaults<T>>>,
    /// None where every service sends, or none does.
    pub(crate) expected: Option<Expected>,
    /// Run time of the last message used, or of the last silence counted since, ns.
    heard_ns: i64,
    pub(crate) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Subscriber<T> {
    pub(crate) fn new(
        port: Rc<dyn Receiver<T>>,
        waiter: Option<Waiter>,
        members: Rc<Members>,
        fences: Option<Fences>,
        clock: Option<Rc<Clock>>,
        faults: Rc<Faults>,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        Self {
            rooms: Rooms::new(|| port.room()),
            port,
            waiter,
            arrived_step: None,
            last: [(0, 0); Service::ALL.len() + 1],
            channels: Default::default(),
            members,
            fences,
            senders: [None; REMEMBERED_SENDERS],
            next_sender: 0,
            clock,
            faults,
            channel_faults: None,
            expected: None,
            heard_ns: 0,
            tally,
        }
    }

    /// The newest sample of the last update. A large one is borrowed from its sender.
    #[must_use]
    pub fn newest(&self) -> Option<&T> {
        self.rooms.newest()
    }

    /// Bytes that were copied so far to take samples.
    #[must_use]
    pub fn copied_bytes(&self) -> u64 {
        self.tally.borrow().copied_bytes
    }

    /// Stamps of the newest sample, for the header of what is computed from it.
    #[must_use]
    pub fn origin(&self) -> Origin {
        self.newest().map_or(Origin::NONE, |sample| Origin::of(sample.header()))
    }

    /// Takes all samples up to `step`, calling `each` on every one that may be used, in order.
    pub(crate) fn drain(
        &mut self,
        step: u64,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        loop {
            if !self.rooms.take_up() && !self.receive()? {
                break;
            }
            let Some(sample) = self.rooms.incoming().get() else { break };
            // A wrong step is caught by the check; the wait for it is not to last for ever.
            let of_step = sample.header().step;
            if of_step > step {
                self.rooms.put_off();
                break;
            }
            self.arrived_step = self.arrived_step.max(Some(of_step));
            if self.faults.disturbs(T::TOPIC) {
                let now_ns = self.now_ns();
                let faults =
                    self.channel_faults.get_or_insert_with(|| Box::new(ChannelFaults::new()));
                let sealing = self.port.sealing();
                if faults.take(sample, sealing, &self.faults, now_ns) {
                    self.check(&mut each);
                }
            } else {
                self.check(&mut each);
            }
        }
        if let Some(mut faults) = self.channel_faults.take() {
            let now_ns = self.now_ns();
            while let Some(disturbed) = faults.hand_over(now_ns) {
                self.rooms.incoming_mut().copy(&disturbed.message);
                let passed = self.check(&mut each);
                if let Some(number) = disturbed.corrupted_by.filter(|_| passed) {
                    self.faults.went_undetected(number);
                }
            }
            self.channel_faults = Some(faults);
        }
        Ok(())
    }

    fn now_ns(&self) -> i64 {
        self.clock.as_ref().map_or(0, |clock| clock.now_ns())
    }

    /// Keeps the sample if it passes the end-to-end check; whether it did.
    fn check(&mut self, each: &mut impl FnMut(&T)) -> bool {
        let Some(sample) = self.rooms.incoming().get() else { return false };
        let header = sample.header();
        let source = match T::TOPIC.sources() {
            [only] => only.to_wire(),
            _ => header.source,
        };
        let tally = &mut self.tally.borrow_mut();
        let Some(channel) = self.channels.get_mut(source as usize) else {
            tally.e2e.error += 1;
            return false;
        };
        let bytes = bytemuck::bytes_of(sample);
        let bytes = profile7::protected(bytes, T::LAYOUT.bytes_in_use(bytes));
        if self.fences.as_ref().is_some_and(|f| !f.accept(source, header.incarnation)) {
            // Of a process that its standby has replaced.
            tally.e2e.wrong_sequence += 1;
            return false;
        }
        let (data_id, incarnation) = (T::TOPIC.data_id(source), header.incarnation);
        let accepted = match self.rooms.incoming().is_as_sent() {
            true => channel.accept_as_sent(bytes, data_id, incarnation, &mut tally.e2e),
            false => channel.accept(bytes, data_id, incarnation, &mut tally.e2e),
        };
        if !accepted {
            return false;
        }
        if let Some(clock) = &self.clock {
            let now_ns = clock.now_ns();
            if header.acquisition_ns > now_ns.saturating_add(FUTURE_TOLERANCE_NS) {
                tally.e2e.from_the_future += 1;
                return false;
            }
            self.heard_ns = now_ns;
        }
        each(sample);
        self.rooms.keep();
        true
    }

    /// Counts a silence of more than a period of the topic's source as the standard's "no new data",
    /// once in a period.
    pub(crate) fn note_silence(&mut self, now_ns: i64) {
        let Some(Expected { source, period_ns, .. }) = self.expected else { return };
        if now_ns - self.heard_ns > (SILENCE * period_ns as f64) as i64 {
            self.heard_ns += period_ns;
            self.channels[source.to_wire() as usize].nothing_new(&mut self.tally.borrow_mut().e2e);
        }
    }

    /// Takes the next sample of a member of the group; false if there is none.
    fn receive(&mut self) -> Result<bool, RuntimeError> {
        loop {
            self.rooms.incoming_mut().clear();
            let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
            let Some(arrival) = self.port.receive(self.rooms.incoming_mut()).map_err(error)? else {
                return Ok(false);
            };
            let Some(sample) = self.rooms.incoming().get() else { return Ok(false) };
            let &Header { source, incarnation, sequence, .. } = sample.header();
            if !self.knows(arrival.sender, source, incarnation) {
                self.tally.borrow_mut().e2e.unknown_sender += 1;
                continue;
            }
            let mut tally = self.tally.borrow_mut();
            if let Some(last) = self.last.get_mut(source as usize) {
                // A new incarnation counts from 1 again; the first sample of a late joiner is no loss.
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

    /// True if `sender` is the process that it says it is.
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

    /// True if the newest sample is of step `due` or later.
    pub(crate) fn reaches(&self, due: u64) -> bool {
        self.newest().is_some_and(|sample| sample.header().step >= due)
    }

    /// Waits until the sample of step `due` arrived.
    pub(crate) fn await_step(
        &mut self,
        due: u64,
        step: u64,
        end: &End,
        patience: Duration,
    ) -> Result<(), RuntimeError> {
        let mut waiting_since = None;
        loop {
            let ticket = self.ticket();
            self.drain(step, |_| {})?;
            if self.arrived_step.is_some_and(|arrived| arrived >= due) {
                return Ok(());
            }
            if end.is_before(step) {
                return Err(RuntimeError::Stopped);
            }
            let starved = |waited: Duration| {
                let waited_s = waited.as_secs_f64();
                Err(RuntimeError::Starved { topic: T::TOPIC, step: due, waited_s })
            };
            if self.waiter().is_in_process() {
                // The turns of a thread tell by themselves when a wait is in vain.
                if self.waiter().is_in_vain() {
                    return starved(Duration::ZERO);
                }
            } else {
                let waited = waiting_since.get_or_insert_with(Instant::now).elapsed();
                if waited > patience {
                    return starved(waited);
                }
            }
            self.wait(ticket, Duration::from_millis(20))?;
        }
    }

    /// Waits for the very sample that `origin` names, and takes nothing else; keeps the newest one
    /// if it is that.
    pub(crate) fn await_sample(
        &mut self,
        origin: Origin,
        step: u64,
        end: &End,
        patience: Duration,
    ) -> Result<(), RuntimeError> {
        if !origin.is_some() || self.origin() == origin {
            return Ok(());
        }
        let since = Instant::now();
        loop {
            let ticket = self.ticket();
            let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
            while self.port.receive(self.rooms.incoming_mut()).map_err(error)?.is_some() {
                let named = |sample: &T| Origin::of(sample.header()) == origin;
                if self.rooms.incoming().get().is_some_and(named) {
                    self.rooms.keep();
                    return Ok(());
                }
            }
            if end.is_now() {
                return Err(RuntimeError::Stopped);
            }
            // The turns of a thread tell by themselves when a wait is in vain.
            if self.waiter().is_in_vain() || since.elapsed() > patience {
                let waited_s = since.elapsed().as_secs_f64();
                return Err(RuntimeError::Starved { topic: T::TOPIC, step, waited_s });
            }
            self.wait(ticket, Duration::from_millis(20))?;
        }
    }

    /// To be taken before a look at the topic that may end in a wait.
    pub(crate) fn ticket(&self) -> Ticket {
        self.waiter().ticket()
    }

    /// Waits for a sample sent since `ticket` was taken, at most for `timeout`.
    pub(crate) fn wait(&self, ticket: Ticket, timeout: Duration) -> Result<(), RuntimeError> {
        self.waiter()
            .wait(ticket, timeout)
            .map_err(|reason| TransportError::System { what: "waiting", reason })
            .map_err(|reason| RuntimeError::Receive { topic: T::TOPIC, reason })
    }

    fn waiter(&self) -> &Waiter {
        self.waiter.as_ref().expect("a port that waits was opened with a waiter")
    }
}
