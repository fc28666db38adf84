//! Typed ends of a topic, with stamps, counts and digests.

use super::link::End;
use super::transport::{Receiver, Sender};
use super::waking::{Ticket, Waiter, Waker};
use super::{Clock, Mode, RuntimeError, Timetable};
use crate::messages::{Message, Topic};
use crate::report::{ReceivedTopic, SentTopic};
use crate::{Service, messages::Origin};
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
    pub(super) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Publisher<T> {
    /// Completes the header of `message` (sequence, source, publish stamp) and sends it. Allocates
    /// nothing.
    ///
    /// # Errors
    /// [`RuntimeError::Send`] if the transport refuses it.
    pub fn send(&mut self, mut message: T) -> Result<(), RuntimeError> {
        let error = |reason: String| RuntimeError::Send { topic: T::TOPIC, reason };
        let header = message.header_mut();
        header.sequence = self.tally.borrow().messages + 1;
        header.incarnation = self.incarnation;
        header.source = self.source.to_wire();
        header.publish_ns = self.clock.now_ns();
        let step = header.step;
        self.port.send(&message).map_err(error)?;
        self.tally.borrow_mut().count(&message);
        if let Some(waker) = &self.waker
            && (self.timetable.is_awaited(T::TOPIC, step) || step.is_multiple_of(DRAIN_STEPS))
        {
            waker.wake();
        }
        Ok(())
    }
}

/// The receiving end of `T`'s topic: keeps the newest sample that is not of a later step.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    pub(super) port: Rc<dyn Receiver<T>>,
    pub(super) waiter: Option<Waiter>,
    pub(super) newest: Option<T>,
    pub(super) ahead: Option<T>,
    /// Incarnation and sequence number of the last message of each source.
    pub(super) last: [(u32, u64); Service::ALL.len() + 1],
    pub(super) tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Subscriber<T> {
    pub(super) fn new(
        port: Rc<dyn Receiver<T>>,
        waiter: Option<Waiter>,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        let last = [(0, 0); Service::ALL.len() + 1];
        Self { port, waiter, newest: None, ahead: None, last, tally }
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

    /// Takes all samples up to `step`, calling `each` on every one in order.
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
                    None => return Ok(()),
                },
            };
            if sample.header().step > step {
                self.ahead = Some(sample);
                return Ok(());
            }
            each(&sample);
            self.newest = Some(sample);
        }
    }

    fn receive(&mut self) -> Result<Option<T>, RuntimeError> {
        let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
        let Some(sample) = self.port.receive().map_err(error)? else { return Ok(None) };
        let header = sample.header();
        let mut tally = self.tally.borrow_mut();
        if let Some(last) = self.last.get_mut(header.source as usize) {
            // A new incarnation counts from 1 again; the first sample of a late joiner is no loss.
            if last.0 == header.incarnation && last.1 > 0 {
                tally.lost += header.sequence.saturating_sub(last.1 + 1);
            }
            *last = (header.incarnation, header.sequence);
        }
        tally.count(&sample);
        Ok(Some(sample))
    }

    /// True if the newest sample is of step `due` or later.
    pub(super) fn reaches(&self, due: u64) -> bool {
        self.newest.as_ref().is_some_and(|sample| sample.header().step >= due)
    }

    /// Waits until the sample of step `due` was taken.
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
            if self.reaches(due) {
                return Ok(());
            }
            if end.is_before(step) {
                return Err(RuntimeError::Stopped);
            }
            let since = *waiting_since.get_or_insert_with(Instant::now);
            if since.elapsed() > patience {
                let waited_s = since.elapsed().as_secs_f64();
                return Err(RuntimeError::Starved { topic: T::TOPIC, step: due, waited_s });
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
