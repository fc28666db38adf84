//! The check of a message that arrived: sender, epoch, end-to-end protection, clock.

use super::Tally;
use crate::Clock;
use crate::survival::fence::Peers;
use crate::transport::{Arrival, Held};
use messages::e2e::Channel;
use messages::{Header, Message, Service};
use std::cell::RefCell;
use std::rc::Rc;

/// Periods of its source after which a topic without a message counts as silent.
const SILENCE: f64 = 1.5;

/// Expected period of messages of a topic in a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    pub(crate) source: Service,
    /// Steps between two of its releases.
    pub(crate) stride: u64,
    /// Time between two messages, ns.
    pub(crate) period_ns: i64,
}

#[derive(Debug)]
pub(crate) struct Check {
    /// The members of the group and their epochs. `None` in the memory of one process, in which each sender is known
    /// and no message is lost.
    peers: Option<Peers>,
    /// Incarnation and sequence number of the last message of each source.
    last: [(u32, u64); Service::ALL.len() + 1],
    /// `None` where nothing can happen to a message on its way: each one passes.
    channels: Option<[Channel; Service::ALL.len() + 1]>,
    /// `None` for an observer, which has no part in the run's time.
    pub(crate) clock: Option<Rc<Clock>>,
    /// `None` if every service sends, or if no service does.
    pub(crate) expected: Option<Expected>,
    /// Run time of the last message used, or of the last silence counted since, ns.
    heard_ns: i64,
    tally: Rc<RefCell<Tally>>,
}

impl Check {
    /// The check of messages of `peers`, or of those in memory. Each message is judged if `is_judged`.
    pub(crate) fn new(peers: Option<&Peers>, is_judged: bool, tally: Rc<RefCell<Tally>>) -> Self {
        Self {
            peers: peers.cloned(),
            last: [(0, 0); Service::ALL.len() + 1],
            channels: is_judged.then(Default::default),
            clock: None,
            expected: None,
            heard_ns: 0,
            tally,
        }
    }

    /// Counts messages that arrived, the newest with this header; false if they are not of a member of the group.
    pub(crate) fn admit<T: Message>(&mut self, header: &Header, arrival: &Arrival) -> bool {
        let &Header { source, incarnation, sequence, .. } = header;
        let mut tally = self.tally.borrow_mut();
        if let (Some(pid), Some(peers)) = (arrival.pid, &self.peers) {
            let sources = T::TOPIC.sources();
            let may_send = |service: &Service| service.to_wire() == source;
            if !(sources.is_empty() || sources.iter().any(may_send))
                || !peers.words.is_member(source, incarnation, pid)
            {
                tally.e2e.unknown_sender += 1;
                return false;
            }
            if let Some(last) = self.last.get_mut(source as usize) {
                // A new incarnation counts from 1 again; the first sample of a late joiner is not a loss.
                if last.0 == incarnation && last.1 > 0 {
                    tally.lost += sequence.saturating_sub(last.1 + 1);
                }
                *last = (incarnation, sequence);
            }
        }
        tally.messages += arrival.messages;
        true
    }

    /// True if the message may be used, which stands for `messages` since the last look; counts the outcome. Stamps
    /// ahead of the reader's clock are moved back to it.
    pub(crate) fn pass<T: Message>(&mut self, incoming: &mut Held<T>, messages: u64) -> bool {
        match &mut self.channels {
            None => self.tally.borrow_mut().e2e.ok += messages,
            Some(channels) => {
                let tally = &mut self.tally.borrow_mut();
                if !is_accepted(channels, self.peers.as_ref(), tally, incoming) {
                    return false;
                }
            }
        }
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
        let Some(channels) = &mut self.channels else { return };
        if now_ns - self.heard_ns > (SILENCE * period_ns as f64) as i64 {
            self.heard_ns += period_ns;
            channels[source.to_wire() as usize].nothing_new(&mut self.tally.borrow_mut().e2e);
        }
    }
}

/// True if epoch and end-to-end protection accept the message; counts the outcome.
fn is_accepted<T: Message>(
    channels: &mut [Channel],
    peers: Option<&Peers>,
    tally: &mut Tally,
    incoming: &Held<T>,
) -> bool {
    let Some(sample) = incoming.get() else { return false };
    let header = sample.header();
    let source = match T::TOPIC.sources() {
        [only] => only.to_wire(),
        _ => header.source,
    };
    let Some(channel) = channels.get_mut(source as usize) else {
        tally.e2e.error += 1;
        return false;
    };
    let bytes = bytemuck::bytes_of(sample);
    let bytes = &bytes[..T::LAYOUT.bytes_in_use(bytes)];
    if peers.is_some_and(|peers| !peers.accept(source, header.incarnation)) {
        // A message of a process that its standby has replaced.
        tally.e2e.wrong_sequence += 1;
        return false;
    }
    channel.accept(bytes, T::TOPIC.data_id(source), header.incarnation, &mut tally.e2e)
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
