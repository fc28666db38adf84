//! Messages of all topics in the order of their publication, whatever order they were taken in.
//!
//! In realtime a message is held back until any that was published before it must have come. In lockstep the wall clock
//! has no meaning. A message waits until every service was received at a later instant of simulated time. So the same
//! run gives the same order. Messages of one instant follow the order of topics, senders and their own numbers.

use messages::{Header, TOPICS, Topic};
use runtime::Mode;
use std::collections::{BTreeMap, BTreeSet};

/// Time that a message may take from its publication to here in realtime, ns.
const HOLD_NS: i64 = 200_000_000;
/// Most bytes that are held back. Beyond them the earliest go on, whatever may come.
const MOST_HELD: usize = 64 << 20;

/// A message with its place in time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Placed {
    pub(crate) topic: Topic,
    /// Time of its publication by its sender's clock, ns of run time. It is never earlier than the previous message's.
    pub(crate) log_time_ns: i64,
    pub(crate) bytes: Vec<u8>,
}

/// Place of a message in the order: instant, place of its topic, sender, incarnation, arrival.
type Key = (i64, usize, u32, u32, u64);

/// Brings messages into order.
#[derive(Debug)]
pub(crate) struct Sequencer {
    mode: Mode,
    /// Senders that must be received before an instant is over, by their numbers.
    senders: BTreeSet<u32>,
    held: BTreeMap<Key, (Topic, Vec<u8>)>,
    held_bytes: usize,
    arrivals: u64,
    /// Newest instant of each sender on each topic, and of each sender.
    streams: BTreeMap<(Topic, u32), i64>,
    newest: BTreeMap<u32, i64>,
    /// The instant that every sender had passed at the last look: all before it has come since.
    passed_ns: i64,
    last_ns: i64,
}

impl Sequencer {
    /// Makes it for a run with these senders.
    pub(crate) fn new(mode: Mode, senders: impl IntoIterator<Item = u32>) -> Self {
        Self {
            mode,
            senders: senders.into_iter().collect(),
            held: BTreeMap::new(),
            held_bytes: 0,
            arrivals: 0,
            streams: BTreeMap::new(),
            newest: BTreeMap::new(),
            passed_ns: i64::MIN,
            last_ns: i64::MIN,
        }
    }

    /// Adds a message that was taken at `now_ns` of run time. Messages of one sender on one topic must come
    /// in their order.
    pub(crate) fn add(&mut self, topic: Topic, bytes: &[u8], now_ns: i64) {
        let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
        let published_ns = match self.mode {
            // A clock ahead of its time is wrong.
            Mode::Realtime => header.publish_ns.min(now_ns),
            Mode::Lockstep => header.publish_ns,
        };
        let stream = self.streams.entry((topic, header.source)).or_insert(published_ns);
        *stream = published_ns.max(*stream);
        let newest = self.newest.entry(header.source).or_insert(*stream);
        *newest = (*newest).max(*stream);
        let rank = TOPICS.iter().position(|known| *known == topic).expect("every topic is there");
        let key = (*stream, rank, header.source, header.incarnation, self.arrivals);
        self.arrivals += 1;
        self.held_bytes += bytes.len();
        self.held.insert(key, (topic, bytes.to_vec()));
    }

    /// The messages whose turn has come at `now_ns` of run time. Every topic was looked at before, until nothing was
    /// left.
    pub(crate) fn ready(&mut self, now_ns: i64) -> Vec<Placed> {
        let before_ns = match self.mode {
            Mode::Realtime => now_ns.saturating_sub(HOLD_NS),
            // Messages passed before this look were sent before it, so they have come with it.
            Mode::Lockstep => {
                let passed_ns = self.passed_by_all();
                std::mem::replace(&mut self.passed_ns, passed_ns)
            }
        };
        let mut ready = Vec::new();
        while let Some(first) = self.held.first_entry()
            && (first.key().0 < before_ns || self.held_bytes > MOST_HELD)
        {
            let ((at_ns, ..), (topic, bytes)) = first.remove_entry();
            ready.push(self.place(at_ns, topic, bytes));
        }
        ready
    }

    /// All that is left, when nothing will come any more.
    pub(crate) fn rest(&mut self) -> Vec<Placed> {
        let held = std::mem::take(&mut self.held);
        held.into_iter()
            .map(|((at_ns, ..), (topic, bytes))| self.place(at_ns, topic, bytes))
            .collect()
    }

    fn place(&mut self, at_ns: i64, topic: Topic, bytes: Vec<u8>) -> Placed {
        self.held_bytes -= bytes.len();
        self.last_ns = self.last_ns.max(at_ns);
        Placed { topic, log_time_ns: self.last_ns, bytes }
    }

    /// The instant that every sender has passed.
    fn passed_by_all(&self) -> i64 {
        let passed = self.senders.iter().map(|sender| self.newest.get(sender).copied());
        passed.min().flatten().unwrap_or(i64::MIN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Command, Heartbeat, Message, Odometry, Service};

    fn message<T: Message>(source: Service, publish_ns: i64) -> (Topic, Vec<u8>) {
        let mut message = T::zeroed();
        message.header_mut().source = source.to_wire();
        message.header_mut().publish_ns = publish_ns;
        (T::TOPIC, bytemuck::bytes_of(&message).to_vec())
    }

    fn order(placed: &[Placed]) -> Vec<(Topic, i64)> {
        placed.iter().map(|placed| (placed.topic, placed.log_time_ns)).collect()
    }

    const PLANT: Service = Service::Plant;
    const CONTROLLER: Service = Service::Controller;

    #[test]
    fn in_lockstep_an_instant_waits_for_every_sender_and_for_one_more_look() {
        let senders = [PLANT, CONTROLLER].map(Service::to_wire);
        let mut sequencer = Sequencer::new(Mode::Lockstep, senders);
        let add = |sequencer: &mut Sequencer, (topic, bytes): (Topic, Vec<u8>)| {
            sequencer.add(topic, &bytes, 0);
        };
        add(&mut sequencer, message::<Command>(CONTROLLER, 10));
        add(&mut sequencer, message::<Odometry>(PLANT, 20));
        assert!(sequencer.ready(0).is_empty(), "no instant has been passed by both");
        // Behind the same sender's later odometry, on another topic.
        add(&mut sequencer, message::<Heartbeat>(PLANT, 10));
        add(&mut sequencer, message::<Command>(CONTROLLER, 20));
        assert_eq!(order(&sequencer.ready(0)), []);
        let expected = [(Topic::Command, 10), (Topic::Heartbeat, 10)];
        assert_eq!(order(&sequencer.ready(0)), expected);
        let rest = order(&sequencer.rest());
        assert_eq!(rest, [(Topic::Odometry, 20), (Topic::Command, 20)]);
    }

    #[test]
    fn in_realtime_the_order_is_that_of_publication_and_never_goes_back() {
        let mut sequencer = Sequencer::new(Mode::Realtime, []);
        let messages = [
            message::<Odometry>(PLANT, 50),
            message::<Command>(CONTROLLER, 40),
            // A clock that is ahead: it counts up to the present.
            message::<Heartbeat>(CONTROLLER, i64::MAX),
        ];
        for (topic, bytes) in messages {
            sequencer.add(topic, &bytes, 60);
        }
        assert!(sequencer.ready(60).is_empty());
        let ready = sequencer.ready(61 + HOLD_NS);
        let expected = [(Topic::Command, 40), (Topic::Odometry, 50), (Topic::Heartbeat, 60)];
        assert_eq!(order(&ready), expected);
        // Much too late: it keeps the order of the file.
        let (topic, bytes) = message::<Odometry>(PLANT, 10);
        sequencer.add(topic, &bytes, 70);
        assert_eq!(order(&sequencer.rest()), [(Topic::Odometry, 60)]);
    }
}
