//! The receive thread: turns packets into frames and answers questions.

use crate::clock::Exchange;
use crate::endpoint::{Endpoint, Origin, Received};
use crate::envelope::{Content, Envelope, MAX_PACKET, Packet};
use crate::frame::Frame;
use crate::stations::{Counts, Stations};
use crate::wall_clock_ns;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Identity of this end of the carrier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    pub(crate) sender: u64,
    /// The wall clock at its run time 0; only roadside units have one and answer questions.
    pub(crate) start_ns: Option<i64>,
}

/// State shared by the thread and the carrier's owner.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) counts: Counts,
    stations: Mutex<Stations>,
}

pub(crate) struct Listener {
    pub(crate) endpoint: Box<dyn Endpoint>,
    pub(crate) identity: Identity,
    pub(crate) queue: SyncSender<Frame>,
    pub(crate) shared: Arc<Shared>,
}

impl Shared {
    /// The known senders. A panic of the other thread was reported there.
    pub(crate) fn stations(&self) -> MutexGuard<'_, Stations> {
        self.stations.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Identity {
    /// A new identity; the number is drawn from the standard library's random hash keys.
    pub(crate) fn draw(start_ns: Option<i64>) -> Self {
        use std::hash::{BuildHasher, Hasher};
        let state = std::collections::hash_map::RandomState::new();
        let mut hasher = state.build_hasher();
        hasher.write_u32(std::process::id());
        Self { sender: hasher.finish(), start_ns }
    }

    pub(crate) fn envelope(&self, sequence: u64) -> Envelope {
        let Self { sender, start_ns } = *self;
        Envelope { sender, sequence, sent_ns: wall_clock_ns(), start_ns }
    }
}

impl Listener {
    /// Receives until the carrier is closed.
    pub(crate) fn run(mut self) {
        let mut buffer = vec![0; 65_536];
        loop {
            let wait = if self.identity.start_ns.is_none() { self.ask() } else { LONGEST_WAIT };
            match self.endpoint.receive(wait, &mut buffer) {
                Received::Packet(length, origin) => self.take(&buffer[..length], origin),
                Received::Nothing => {}
                Received::Closed => return,
            }
        }
    }

    /// Asks the stations whose turn it is; returns the time until the next turn.
    fn ask(&mut self) -> Duration {
        loop {
            let mut stations = self.shared.stations();
            let Some(origin) = stations.next_question() else {
                return stations.until_question().unwrap_or(LONGEST_WAIT).min(LONGEST_WAIT);
            };
            drop(stations);
            self.send(origin, None, Content::Question);
        }
    }

    fn send(&mut self, to: Origin, asker: Option<u64>, content: Content<'_>) {
        let mut room = [0; MAX_PACKET];
        let length = self.identity.envelope(0).write(content, &mut room);
        self.endpoint.send(to, asker, &room[..length]);
    }

    fn take(&mut self, packet: &[u8], origin: Origin) {
        let now_ns = wall_clock_ns();
        let counts = &self.shared.counts;
        match Packet::read(packet) {
            Packet::Malformed => Counts::count(&counts.malformed),
            Packet::Bare(bytes) => {
                Counts::count(&counts.received);
                self.hand_over(Frame::new(bytes, now_ns));
            }
            Packet::Ours(envelope, _) if envelope.sender == self.identity.sender => {}
            Packet::Ours(envelope, Content::Frame(bytes)) => {
                let clock = self.shared.stations().frame(&envelope, origin, now_ns);
                let Some(clock) = clock else { return };
                Counts::count(&counts.received);
                self.hand_over(Frame::new(bytes, now_ns).map(|frame| Frame {
                    sender: Some(envelope.sender),
                    sent_ns: Some(envelope.sent_ns),
                    start_ns: envelope.start_ns,
                    clock,
                    ..frame
                }));
            }
            Packet::Ours(envelope, Content::Question) => {
                if self.identity.start_ns.is_some() {
                    let (to, asked_ns) = (envelope.sender, envelope.sent_ns);
                    let answer = Content::Answer { to, asked_ns, heard_ns: now_ns };
                    self.send(origin, Some(to), answer);
                }
            }
            Packet::Ours(envelope, Content::Answer { to, asked_ns, heard_ns }) => {
                if to == self.identity.sender {
                    let answered_ns = envelope.sent_ns;
                    let exchange =
                        Exchange { asked_ns, heard_ns, answered_ns, returned_ns: now_ns };
                    self.shared.stations().answer(envelope.sender, exchange);
                }
            }
        }
    }

    fn hand_over(&self, frame: Option<Frame>) {
        // A closed queue means that the carrier is closing.
        if frame.is_none_or(|frame| self.queue.try_send(frame).is_err()) {
            Counts::count(&self.shared.counts.dropped);
        }
    }
}
