//! The receiving end of a topic.

use super::Tally;
use super::check::Check;
use crate::faults::Disturbed;
use crate::life::link::End;
use crate::report::ReceivedTopic;
use crate::transport::waking::Waiter;
use crate::transport::{Held, Receiver};
use crate::{RuntimeError, TransportError};
use messages::{Message, Origin, SMALL_BYTES};
use std::cell::RefCell;
use std::mem::swap;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The receiving end of `T`'s topic. It keeps the newest sample that passed all checks and is not of a later step.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    port: Rc<Receiver>,
    waiter: Option<Waiter>,
    newest: Held<T>,
    /// The sample that is looked at.
    incoming: Held<T>,
    /// One of a later step than the reader's.
    ahead: Held<T>,
    /// Newest step of which a sample arrived, whatever became of it.
    arrived_step: Option<u64>,
    /// Stamps of the newest sample as its sender made them.
    origin: Origin,
    /// Faults of the channel; `None` where none can come to act, and none waits for these messages.
    disturbed: Option<Disturbed<T>>,
    check: Check,
    tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Subscriber<T> {
    /// A receiving end behind `port`. It can wait if it has a waiter.
    pub(crate) fn new(
        port: Rc<Receiver>,
        waiter: Option<Waiter>,
        disturbed: Option<Disturbed<T>>,
        check: Check,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        Self {
            waiter,
            newest: port.room(),
            incoming: port.room(),
            ahead: port.room(),
            port,
            arrived_step: None,
            origin: Origin::NONE,
            disturbed,
            check,
            tally,
        }
    }

    /// The newest sample of the last update. A large one is borrowed from its sender. Its stamps are not later than its
    /// arrival: those of a sender whose clock is ahead are moved back.
    pub fn newest(&self) -> Option<&T> {
        self.newest.get()
    }

    /// Bytes that were copied so far to take samples.
    pub fn copied_bytes(&self) -> u64 {
        if size_of::<T>() > SMALL_BYTES {
            return 0;
        }
        self.tally.borrow().messages * size_of::<T>() as u64
    }

    /// Stamps of the newest sample as its sender made them, for the header of what is computed from it.
    pub fn origin(&self) -> Origin {
        self.newest().map_or(Origin::NONE, |_| self.origin)
    }

    /// Takes all samples that arrived, calling `each` on every one that may be used, in order.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn drain(&mut self, each: impl FnMut(&T)) -> Result<(), RuntimeError> {
        self.drain_to(u64::MAX, each)
    }

    pub fn received(&self) -> ReceivedTopic {
        self.tally.borrow().received(T::TOPIC)
    }

    /// Takes all samples up to `step`, calling `each` on every one that may be used, in order. Where the carrier has
    /// the newest one alone, that one stands for those since the last look.
    pub(crate) fn drain_to(
        &mut self,
        step: u64,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        while let Some(messages) = self.next()? {
            let Some(sample) = self.incoming.get() else { break };
            // The check refuses a wrong step; the wait for it must end.
            let of_step = sample.header().step;
            if of_step > step {
                swap(&mut self.ahead, &mut self.incoming);
                break;
            }
            self.arrived_step = self.arrived_step.max(Some(of_step));
            if self.disturbed.as_mut().is_none_or(|channel| channel.passes(sample)) {
                self.judge(messages, &mut each);
            }
        }
        while let Some(late) = self.disturbed.as_mut().and_then(Disturbed::hand_over) {
            self.incoming.copy(&late.message);
            let passed = self.judge(1, &mut each);
            if let (Some(channel), true) = (&self.disturbed, passed) {
                channel.note_passed(&late);
            }
        }
        Ok(())
    }

    /// Takes the next sample of a member of the group, and how many it stands for; `None` if there is none.
    fn next(&mut self) -> Result<Option<u64>, RuntimeError> {
        if self.ahead.get().is_some() {
            self.incoming.clear();
            swap(&mut self.ahead, &mut self.incoming);
            return Ok(Some(1));
        }
        loop {
            self.incoming.clear();
            let taken = self.port.receive().map_err(refused::<T>)?;
            let Some((message, arrival)) = taken else { return Ok(None) };
            self.incoming.take(message);
            let Some(sample) = self.incoming.get() else { return Ok(None) };
            if self.check.admit::<T>(sample.header(), &arrival) {
                return Ok(Some(arrival.messages));
            }
        }
    }

    /// Keeps the incoming sample if it passes the checks.
    fn judge(&mut self, messages: u64, each: &mut impl FnMut(&T)) -> bool {
        let Some(sent) = self.incoming.get().map(|sample| Origin::of(sample.header())) else {
            return false;
        };
        let passed = self.check.pass(&mut self.incoming, messages);
        if let Some(sample) = self.incoming.get().filter(|_| passed) {
            each(sample);
            self.keep(sent);
        }
        passed
    }

    /// Makes the incoming sample, which was sent with these stamps, the newest.
    fn keep(&mut self, sent: Origin) {
        self.origin = sent;
        swap(&mut self.newest, &mut self.incoming);
        self.incoming.clear();
    }

    /// Notes at `now_ns` that all samples that were due are taken.
    pub(crate) fn settle(&mut self, now_ns: i64) {
        self.check.note_silence(now_ns);
        if let Some(channel) = &self.disturbed {
            channel.observe(self.newest.get());
        }
    }

    /// Steps between two releases of the topic's source; `None` if every service sends, or none does.
    pub(crate) fn stride(&self) -> Option<u64> {
        self.check.expected.map(|expected| expected.stride)
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
        let look = |port: &mut Self| {
            port.drain_to(step, |_| {})?;
            Ok(port.arrived_step.is_some_and(|arrived| arrived >= due))
        };
        self.wait_until(look, due, || end.is_before(step), patience)
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
        let rides = T::TOPIC.rides_with().is_some();
        let named = |sent: Origin| origin.means(&sent, rides);
        if !origin.is_some() || named(self.origin()) {
            return Ok(());
        }
        let look = |port: &mut Self| {
            while let Some((message, _)) = port.port.receive().map_err(refused::<T>)? {
                port.incoming.take(message);
                let sent = port.incoming.get().map(|sample| Origin::of(sample.header()));
                if let Some(sent) = sent.filter(|sent| named(*sent)) {
                    port.check.move_back(&mut port.incoming);
                    port.keep(sent);
                    return Ok(true);
                }
            }
            Ok(false)
        };
        self.wait_until(look, step, || end.is_now(), patience)
    }

    /// Waits until `look` finds what it looks for, a sample of `step`; an error when that has lasted for too long.
    fn wait_until(
        &mut self,
        look: impl Fn(&mut Self) -> Result<bool, RuntimeError>,
        step: u64,
        is_over: impl Fn() -> bool,
        patience: Duration,
    ) -> Result<(), RuntimeError> {
        let mut since = None;
        loop {
            let ticket = self.ticket();
            if look(self)? {
                return Ok(());
            }
            if is_over() {
                return Err(RuntimeError::Stopped);
            }
            let waited = match self.waiter().is_in_process() {
                // The turns of a thread show when a wait cannot end.
                true => Duration::ZERO,
                false => since.get_or_insert_with(Instant::now).elapsed(),
            };
            if waited > patience || self.waiter().is_in_vain() {
                let waited_s = waited.as_secs_f64();
                return Err(RuntimeError::Starved(T::TOPIC, step, waited_s));
            }
            self.wait(ticket, Duration::from_millis(20))?;
        }
    }

    /// To be taken before a look at the topic that may end in a wait.
    pub(crate) fn ticket(&self) -> u32 {
        self.waiter().ticket()
    }

    /// Waits for a sample sent since `ticket` was taken, at most for `timeout`.
    pub(crate) fn wait(&self, ticket: u32, timeout: Duration) -> Result<(), RuntimeError> {
        self.waiter()
            .wait(ticket, timeout)
            .map_err(|reason| refused::<T>(TransportError::System("waiting", reason)))
    }

    fn waiter(&self) -> &Waiter {
        self.waiter.as_ref().expect("a port that waits was opened with a waiter")
    }
}

fn refused<T: Message>(reason: TransportError) -> RuntimeError {
    RuntimeError::Topic("receive on", T::TOPIC, reason)
}
