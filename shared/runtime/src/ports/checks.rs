//! The checks of a message that arrived: epoch, end-to-end protection, clock.

use super::tally::Tally;
use crate::Clock;
use crate::survival::fence::Fences;
use crate::transport::Held;
use messages::e2e::{Channel, profile7};
use messages::{Header, Message, Service};
use std::cell::RefCell;
use std::rc::Rc;

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
    /// The processes that may send for the services with a standby.
    fences: Option<Fences>,
    /// `None` for an observer, which has no part in the run's time.
    clock: Option<Rc<Clock>>,
    /// `None` if every service sends, or if no service does.
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

    /// True if the message may be used; counts the outcome. Stamps ahead of the reader's clock are moved back to it.
    pub(crate) fn pass<T: Message>(&mut self, incoming: &mut Held<T>) -> bool {
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
        drop(tally);
        if let Some(clock) = &self.clock {
            self.heard_ns = clock.now_ns();
        }
        if self.move_back(incoming) {
            self.tally.borrow_mut().e2e.from_the_future += 1;
        }
        true
    }

    /// Moves stamps that are ahead of the reader's clock back to it; true if there were any.
    pub(crate) fn move_back<T: Message>(&self, incoming: &mut Held<T>) -> bool {
        let now_ns = self.clock.as_ref().map(|clock| clock.now_ns());
        let header = incoming.get().map(Message::header);
        let Some((acquisition_ns, publish_ns)) =
            header.zip(now_ns).and_then(|(header, now_ns)| moved_back(header, now_ns))
        else {
            return false;
        };
        if let Some(message) = incoming.own() {
            let header = message.header_mut();
            (header.acquisition_ns, header.publish_ns) = (acquisition_ns, publish_ns);
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

/// Acquisition and publication of a message whose stamps are later than its arrival at `now_ns`.
///
/// No message was sent after it arrived. So the sender's clock is ahead, at least by the time from the arrival to the
/// publication. Both stamps move back by that: the sample keeps its age at the publication. A sample is never newer than
/// its publication.
fn moved_back(header: &Header, now_ns: i64) -> Option<(i64, i64)> {
    let Header { acquisition_ns, publish_ns, .. } = *header;
    let ahead_ns = publish_ns.saturating_sub(now_ns).max(0);
    let moved_ns = (acquisition_ns - ahead_ns).min(now_ns);
    (ahead_ns > 0 || moved_ns < acquisition_ns).then_some((moved_ns, publish_ns - ahead_ns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn stamps_ahead_of_the_arrival_move_back_and_keep_the_samples_age() {
        for (acquisition_ms, publish_ms, expected_ms) in [
            (4_950, 5_000, None),
            (4_000, 4_000, None),
            (5_000, 5_000, None),
            (5_060, 5_110, Some((4_950, 5_000))),
            (4_951, 5_001, Some((4_950, 5_000))),
            (3_604_950, 3_605_000, Some((4_950, 5_000))),
            (5_090, 5_000, Some((5_000, 5_000))),
            (5_200, 5_110, Some((5_000, 5_000))),
        ] {
            let mut header = Header::zeroed();
            header.acquisition_ns = acquisition_ms * 1_000_000;
            header.publish_ns = publish_ms * 1_000_000;
            let moved = moved_back(&header, 5_000_000_000);
            let moved_ms = moved.map(|(acquired, sent)| (acquired / 1_000_000, sent / 1_000_000));
            assert_eq!(moved_ms, expected_ms, "{acquisition_ms} {publish_ms}");
        }
    }
}
