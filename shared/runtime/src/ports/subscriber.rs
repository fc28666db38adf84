//! The receiving end of a topic.

use super::checks::Checks;
use super::intake::Intake;
use super::tally::Tally;
use crate::RuntimeError;
use crate::life::link::End;
use crate::transport::waking::{Ticket, Waiter};
use crate::transport::{Receiver, Rooms, TransportError};
use messages::{Message, Origin};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The receiving end of `T`'s topic. It keeps the newest sample that passed all checks and is not of a later step.
#[derive(Debug)]
pub struct Subscriber<T: Message> {
    port: Rc<dyn Receiver<T>>,
    waiter: Option<Waiter>,
    intake: Box<dyn Intake<T>>,
    /// The newest sample, the one that is looked at, and one of a later step than the reader's.
    rooms: Rooms<T>,
    /// Stamps of the newest sample as its sender made them.
    origin: Origin,
    checks: Checks,
    tally: Rc<RefCell<Tally>>,
}

impl<T: Message> Subscriber<T> {
    /// A receiving end of `port`, whose messages come through `intake`.
    pub(crate) fn new(
        port: Rc<dyn Receiver<T>>,
        waiter: Option<Waiter>,
        intake: Box<dyn Intake<T>>,
        checks: Checks,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        let rooms = Rooms::new(|| port.room());
        Self { port, waiter, intake, rooms, origin: Origin::NONE, checks, tally }
    }

    /// The newest sample of the last update. A large one is borrowed from its sender. Its stamps are not later than its
    /// arrival: those of a sender whose clock is ahead are moved back.
    #[must_use]
    pub fn newest(&self) -> Option<&T> {
        self.rooms.newest()
    }

    /// Bytes that were copied so far to take samples.
    #[must_use]
    pub fn copied_bytes(&self) -> u64 {
        self.tally.borrow().copied_bytes
    }

    /// Stamps of the newest sample as its sender made them, for the header of what is computed from it.
    #[must_use]
    pub fn origin(&self) -> Origin {
        self.newest().map_or(Origin::NONE, |_| self.origin)
    }

    /// Takes all samples up to `step`, calling `each` on every one that may be used, in order.
    pub(crate) fn drain(
        &mut self,
        step: u64,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        let Self { intake, rooms, origin, checks, .. } = self;
        intake.drain(step, rooms, &mut |rooms| {
            let sent = rooms.incoming().get().map(|sample| Origin::of(sample.header()));
            let passed = checks.pass(rooms.incoming_mut());
            if let Some((sample, sent)) = rooms.incoming().get().zip(sent).filter(|_| passed) {
                each(sample);
                *origin = sent;
                rooms.keep();
            }
            passed
        })
    }

    /// Notes at `now_ns` that all samples that were due are taken.
    pub(crate) fn settle(&mut self, now_ns: i64) {
        self.checks.note_silence(now_ns);
        self.intake.settled(self.rooms.newest(), now_ns);
    }

    /// Steps between two releases of the topic's source; `None` if every service sends, or none does.
    pub(crate) fn stride(&self) -> Option<u64> {
        self.checks.expected.map(|expected| expected.stride)
    }

    /// Counts of this port.
    pub(crate) fn tally(&self) -> &RefCell<Tally> {
        &self.tally
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
            if self.intake.arrived_step().is_some_and(|arrived| arrived >= due) {
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
                // The turns of a thread show when a wait cannot end.
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
        let rides = T::TOPIC.rides_with().is_some();
        let named = |sent: Origin| origin.means(&sent, rides);
        if !origin.is_some() || named(self.origin()) {
            return Ok(());
        }
        let since = Instant::now();
        loop {
            let ticket = self.ticket();
            let error = |reason| RuntimeError::Receive { topic: T::TOPIC, reason };
            while self.port.receive(self.rooms.incoming_mut()).map_err(error)?.is_some() {
                let sent = self.rooms.incoming().get().map(|sample| Origin::of(sample.header()));
                if let Some(sent) = sent.filter(|sent| named(*sent)) {
                    self.checks.move_back(self.rooms.incoming_mut());
                    self.origin = sent;
                    self.rooms.keep();
                    return Ok(());
                }
            }
            if end.is_now() {
                return Err(RuntimeError::Stopped);
            }
            // The turns of a thread show when a wait cannot end.
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
