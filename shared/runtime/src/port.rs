//! Typed ends of a topic, with stamps, counts and digests.

use super::faults::{Faults, Lies, Wire};
use super::link::End;
use super::members::Members;
use super::transport::{Receiver, Sender, SenderId};
use super::waking::{Ticket, Waiter, Waker};
use super::{Clock, Mode, RuntimeError, Timetable};
use crate::report::{ReceivedTopic, SentTopic};
use messages::e2e::{Channel, Outcomes, profile7};
use messages::{Message, Odometry, Topic};
use messages::{Origin, Service};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};
use xxhash_rust::xxh3::Xxh3Default;

/// A consumer that lags this many steps behind is woken even if no sample is due.
const DRAIN_STEPS: u64 = 16;

/// Counts of a port, shared with the runtime that reports them.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) messages: u64,
    pub(super) lost: u64,
    pub(super) e2e: Outcomes,
    digest: Option<Box<Xxh3Default>>,
}

impl std::fmt::Debug for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tally")
            .field("messages", &self.messages)
            .field("lost", &self.lost)
            .finish_non_exhaustive()
    }
}

impl Tally {
    pub(super) fn new(mode: Mode) -> Rc<RefCell<Self>> {
        let digest = (mode == Mode::Lockstep).then(Box::default);
        Rc::new(RefCell::new(Self { digest, ..Self::default() }))
    }

    fn count<T: Message>(&mut self, message: &T) {
        self.messages += 1;
        if let Some(digest) = &mut self.digest {
            digest.update(bytemuck::bytes_of(message));
        }
    }

    fn digest(&self) -> Option<String> {
        self.digest.as_ref().map(|digest| format!("{:016x}", digest.digest()))
    }

    pub(super) fn sent(&self, topic: Topic) -> SentTopic {
        SentTopic { topic: topic.name().into(), sent: self.messages, digest: self.digest() }
    }

    pub(super) fn received(&self, topic: Topic) -> ReceivedTopic {
        ReceivedTopic {
            topic: topic.name().into(),
            received: self.messages,
            lost: self.lost,
            e2e: self.e2e,
            digest: self.digest(),
        }
    }
}

/// The sending end of `T`'s topic.
#[derive(Debug)]
pub struct Publisher<T: Message> {
    pub(super) port: Rc<dyn Sender<T>>,
    pub(super) waker: Option<Waker>,
    pub(super) clock: Rc<Clock>,
    pub(super) timetable: Timetable,
    pub(super) source: Service,
    pub(super) incarnation: u32,
    pub(super) faults: Rc<Faults>,
    pub(super) lies: Lies<T>,
    pub(super) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Publisher<T> {
    /// Completes the header of `message` (sequence, source, publish stamp, protection) and sends it.
    /// Allocates nothing.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport refuses it.
    pub fn send(&mut self, message: T) -> Result<(), RuntimeError> {
        self.send_stamped(message).map(|_| ())
    }

    /// As [`Self::send`]; returns the publish stamp, ns of run time.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn send_stamped(&mut self, mut message: T) -> Result<i64, RuntimeError> {
        let error = |reason: String| RuntimeError::Send { topic: T::TOPIC, reason };
        let source = self.source.to_wire();
        let sequence = self.tally.borrow().messages + 1;
        let now_ns = self.clock.now_ns();
        let header = message.header_mut();
        header.sequence = sequence;
        header.incarnation = self.incarnation;
        header.source = source;
        header.publish_ns = now_ns;
        let step = header.step;
        if self.faults.in_use() {
            if T::TOPIC == Topic::Odometry {
                let odometry: &Odometry = bytemuck::from_bytes(bytemuck::bytes_of(&message));
                self.faults.ego_at(odometry.position_m, odometry.speed_mps, now_ns);
            }
            self.lies.tell(&mut message, &self.faults, now_ns);
        }
        // The counter is the sequence number's low half: it wraps.
        let data_id = T::TOPIC.data_id(source);
        profile7::protect(bytemuck::bytes_of_mut(&mut message), data_id, sequence as u32);
        self.port.send(&message).map_err(error)?;
        self.tally.borrow_mut().count(&message);
        if let Some(waker) = &self.waker
            && (self.timetable.is_awaited(T::TOPIC, step) || step.is_multiple_of(DRAIN_STEPS))
        {
            waker.wake();
        }
        Ok(now_ns)
    }
}

/// Senders that a port remembers; a group restarts its services less often than that in any while.
const REMEMBERED_SENDERS: usize = 16;
/// A stamp may be so far ahead of the reader's clock: both are one clock of one host, read one after
/// the other, ns.
const FUTURE_TOLERANCE_NS: i64 = 5_000_000;
/// Periods of its source after which a topic without a message counts as silent.
const SILENCE: f64 = 1.5;

/// The receiving end of `T`'s topic: keeps the newest sample that passed the end-to-end check and is
/// not of a later step.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    port: Rc<dyn Receiver<T>>,
    waiter: Option<Waiter>,
    newest: Option<T>,
    ahead: Option<T>,
    /// Newest step of which a message arrived, whatever the check made of it.
    arrived_step: Option<u64>,
    /// Incarnation and sequence number of the last message of each source.
    last: [(u32, u64); Service::ALL.len() + 1],
    channels: [Channel; Service::ALL.len() + 1],
    members: Rc<Members>,
    /// Senders that were looked up, and whether they belong to the group.
    senders: [Option<(SenderId, bool)>; REMEMBERED_SENDERS],
    next_sender: usize,
    /// None for an observer, who has no part in the run's time.
    clock: Option<Rc<Clock>>,
    faults: Rc<Faults>,
    wire: Option<Box<Wire<T>>>,
    /// Run time of the last message used, or of the last silence counted since, ns.
    heard_ns: i64,
    pub(super) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Subscriber<T> {
    pub(super) fn new(
        port: Rc<dyn Receiver<T>>,
        waiter: Option<Waiter>,
        members: Rc<Members>,
        clock: Option<Rc<Clock>>,
        faults: Rc<Faults>,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        Self {
            port,
            waiter,
            newest: None,
            ahead: None,
            arrived_step: None,
            last: [(0, 0); Service::ALL.len() + 1],
            channels: Default::default(),
            members,
            senders: [None; REMEMBERED_SENDERS],
            next_sender: 0,
            clock,
            faults,
            wire: None,
            heard_ns: 0,
            tally,
        }
    }

    /// The newest sample of the last update.
    #[must_use]
    pub fn newest(&self) -> Option<&T> {
        self.newest.as_ref()
    }

    /// Stamps of the newest sample, for the header of what is computed from it.
    #[must_use]
    pub fn origin(&self) -> Origin {
        self.newest.as_ref().map_or(Origin::NONE, |sample| Origin::of(sample.header()))
    }

    /// Takes all samples up to `step`, calling `each` on every one that may be used, in order.
    pub(super) fn drain(
        &mut self,
        step: u64,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        loop {
            let sample = match self.ahead.take() {
                Some(sample) => sample,
                None => match self.receive()? {
                    Some(sample) => sample,
                    None => break,
                },
            };
            // A wrong step is caught by the check; the wait for it is not to last for ever.
            if sample.header().step > step {
                self.ahead = Some(sample);
                break;
            }
            self.arrived_step = self.arrived_step.max(Some(sample.header().step));
            if self.faults.in_use() {
                let now_ns = self.now_ns();
                let wire = self.wire.get_or_insert_with(|| Box::new(Wire::new()));
                wire.take(&sample, &self.faults, now_ns);
            } else {
                self.check(&sample, &mut each);
            }
        }
        if let Some(mut wire) = self.wire.take() {
            let now_ns = self.now_ns();
            while let Some(sample) = wire.hand_over(now_ns) {
                self.check(&sample, &mut each);
            }
            self.wire = Some(wire);
        }
        Ok(())
    }

    fn now_ns(&self) -> i64 {
        self.clock.as_ref().map_or(0, |clock| clock.now_ns())
    }

    /// Keeps the sample if it passes the end-to-end check.
    fn check(&mut self, sample: &T, each: &mut impl FnMut(&T)) {
        let header = sample.header();
        let source = T::TOPIC.source().map_or(header.source, Service::to_wire);
        let tally = &mut self.tally.borrow_mut();
        let Some(channel) = self.channels.get_mut(source as usize) else {
            tally.e2e.error += 1;
            return;
        };
        let bytes = bytemuck::bytes_of(sample);
        if !channel.accept(bytes, T::TOPIC.data_id(source), header.incarnation, &mut tally.e2e) {
            return;
        }
        if let Some(clock) = &self.clock {
            let now_ns = clock.now_ns();
            if header.acquisition_ns > now_ns.saturating_add(FUTURE_TOLERANCE_NS) {
                tally.e2e.from_the_future += 1;
                return;
            }
            self.heard_ns = now_ns;
        }
        each(sample);
        self.newest = Some(*sample);
    }

    /// Counts a silence of more than a period of the topic's source as the standard's "no new data",
    /// once in a period.
    pub(super) fn note_silence(&mut self, now_ns: i64, period_ns: i64) {
        if now_ns - self.heard_ns > (SILENCE * period_ns as f64) as i64
            && let Some(source) = T::TOPIC.source()
        {
            self.heard_ns += period_ns;
            self.channels[source.to_wire() as usize].nothing_new(&mut self.tally.borrow_mut().e2e);
        }
    }

    fn receive(&mut self) -> Result<Option<T>, RuntimeError> {
        loop {
            let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
            let Some((sample, sender)) = self.port.receive().map_err(error)? else {
                return Ok(None);
            };
            let header = sample.header();
            if !self.knows(sender, header.source, header.incarnation) {
                self.tally.borrow_mut().e2e.stranger += 1;
                continue;
            }
            let mut tally = self.tally.borrow_mut();
            if let Some(last) = self.last.get_mut(header.source as usize) {
                // A new incarnation counts from 1 again; the first sample of a late joiner is no loss.
                if last.0 == header.incarnation && last.1 > 0 {
                    tally.lost += header.sequence.saturating_sub(last.1 + 1);
                }
                *last = (header.incarnation, header.sequence);
            }
            tally.count(&sample);
            return Ok(Some(sample));
        }
    }

    /// True if `sender` is the process that it says it is.
    fn knows(&mut self, sender: SenderId, source: u32, incarnation: u32) -> bool {
        if let Some((_, belongs)) = self.senders.iter().flatten().find(|(id, _)| *id == sender) {
            return *belongs;
        }
        let allowed = T::TOPIC.source().is_none_or(|service| service.to_wire() == source);
        let belongs = allowed && self.members.vouch(source, incarnation, sender.pid());
        self.senders[self.next_sender] = Some((sender, belongs));
        self.next_sender = (self.next_sender + 1) % REMEMBERED_SENDERS;
        belongs
    }

    /// True if the newest sample is of step `due` or later.
    pub(super) fn reaches(&self, due: u64) -> bool {
        self.newest.as_ref().is_some_and(|sample| sample.header().step >= due)
    }

    /// Waits until the sample of step `due` arrived.
    pub(super) fn await_step(
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
            let since = *waiting_since.get_or_insert_with(Instant::now);
            if self.waiter().is_in_vain() || since.elapsed() > patience {
                let waited_s = since.elapsed().as_secs_f64();
                return Err(RuntimeError::Starved { topic: T::TOPIC, step: due, waited_s });
            }
            self.wait(ticket, Duration::from_millis(20))?;
        }
    }

    /// Waits for the very sample that `origin` names, and takes nothing else; keeps the newest one
    /// if it is that.
    pub(super) fn await_sample(
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
            while let Some((sample, _)) = self.port.receive().map_err(error)? {
                if Origin::of(sample.header()) == origin {
                    self.newest = Some(sample);
                    return Ok(());
                }
            }
            if end.is_now() {
                return Err(RuntimeError::Stopped);
            }
            if since.elapsed() > patience {
                let waited_s = since.elapsed().as_secs_f64();
                return Err(RuntimeError::Starved { topic: T::TOPIC, step, waited_s });
            }
            self.wait(ticket, Duration::from_millis(20))?;
        }
    }

    /// To be taken before a look at the topic that may end in a wait.
    pub(super) fn ticket(&self) -> Ticket {
        self.waiter().ticket()
    }

    /// Waits for a sample sent since `ticket` was taken, at most for `timeout`.
    pub(super) fn wait(&self, ticket: Ticket, timeout: Duration) -> Result<(), RuntimeError> {
        self.waiter()
            .wait(ticket, timeout)
            .map_err(|e| RuntimeError::Receive { topic: T::TOPIC, reason: e.to_string() })
    }

    fn waiter(&self) -> &Waiter {
        self.waiter.as_ref().expect("whoever waits subscribed with a waiter")
    }
}
