//! The checks of a message that arrived: epoch, end-to-end protection, clock.

use super::tally::Tally;
use crate::Clock;
use crate::survival::fence::Fences;
use crate::transport::Held;
use messages::e2e::{Channel, profile7};
use messages::{Message, Service};
use std::cell::RefCell;
use std::rc::Rc;

/// Longest time by which a stamp may be ahead of the reader's clock, ns. Sender and reader read one clock of one
/// host, one after the other.
const FUTURE_TOLERANCE_NS: i64 = 5_000_000;
/// Periods of its source after which a topic without a message counts as silent.
const SILENCE: f64 = 1.5;

/// Expected period of messages of a topic in a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// The service that sends them.
    pub(crate) source: Service,
    /// Steps between two of its releases.
    pub(crate) stride: u64,
    /// Time between two messages, ns.
    pub(crate) period_ns: i64,
}

/// The checks of one receiving end.
#[derive(Debug)]
pub(crate) struct Checks {
    channels: [Channel; Service::ALL.len() + 1],
    /// The processes that may speak for the services with a standby.
    fences: Option<Fences>,
    /// None for an observer, which has no part in the run's time.
    clock: Option<Rc<Clock>>,
    /// None if every service sends, or none does.
    pub(crate) expected: Option<Expected>,
    /// Run time of the last message used, or of the last silence counted since, ns.
    heard_ns: i64,
    tally: Rc<RefCell<Tally>>,
}

impl Checks {
    pub(crate) fn new(
        fences: Option<Fences>,
        clock: Option<Rc<Clock>>,
        expected: Option<Expected>,
        tally: Rc<RefCell<Tally>>,
    ) -> Self {
        Self { channels: Default::default(), fences, clock, expected, heard_ns: 0, tally }
    }

    /// True if the message may be used; counts the outcome.
    pub(crate) fn pass<T: Message>(&mut self, incoming: &Held<T>) -> bool {
        let Some(sample) = incoming.get() else { return false };
        let header = sample.header();
        let source = match T::TOPIC.sources() {
            [only] => only.to_wire(),
            _ => header.source,
        };
        let mut tally = self.tally.borrow_mut();
        let Some(channel) = self.channels.get_mut(source as usize) else {
            tally.e2e.error += 1;
            return false;
        };
        let bytes = bytemuck::bytes_of(sample);
        let bytes = profile7::protected(bytes, T::LAYOUT.bytes_in_use(bytes));
        if self.fences.as_ref().is_some_and(|f| !f.accept(source, header.incarnation)) {
            // A message of a process that its standby has replaced.
            tally.e2e.wrong_sequence += 1;
            return false;
        }
        let (data_id, incarnation) = (T::TOPIC.data_id(source), header.incarnation);
        let accepted = match incoming.is_as_sent() {
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
        true
    }

    /// Counts a silence of more than a period of the topic's source, once in a period. The standard calls it
    /// "no new data".
    pub(crate) fn note_silence(&mut self, now_ns: i64) {
        let Some(Expected { source, period_ns, .. }) = self.expected else { return };
        if now_ns - self.heard_ns > (SILENCE * period_ns as f64) as i64 {
            self.heard_ns += period_ns;
            self.channels[source.to_wire() as usize].nothing_new(&mut self.tally.borrow_mut().e2e);
        }
    }
}
