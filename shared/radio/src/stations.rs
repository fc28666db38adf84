//! Counts of a carrier's frames, and the known senders with their numbers and clocks.

use crate::clock::{ClockComparison, ClockDifference, Comparison, Exchange};
use crate::endpoint::Origin;
use crate::envelope::Envelope;
use crate::numbers::NUMBERS;
use crate::sequence::Sequence;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Counters that the receive thread and the carrier's owner share.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(crate) sent: AtomicU64,
    pub(crate) not_sent: AtomicU64,
    pub(crate) received: AtomicU64,
    pub(crate) dropped: AtomicU64,
    pub(crate) malformed: AtomicU64,
}

/// Counts of a carrier's frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RadioReport {
    pub carrier: String,
    /// Frames passed to the network.
    pub sent: u64,
    /// Frames that could not be sent: no link, no receiver yet, a full queue.
    pub not_sent: u64,
    /// Frames received, without repeats.
    pub received: u64,
    /// Frames received and not read in time, because the queue to the loop was full.
    pub dropped: u64,
    /// Packets that are not frames: empty, too long, or with a broken envelope.
    pub malformed: u64,
    /// Senders that identify themselves.
    pub stations: Vec<StationReport>,
}

/// Counts of one sender's frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationReport {
    /// Number of the sender in hexadecimal digits, random at each start.
    pub sender: String,
    pub received: u64,
    /// Frames between the first and the last received one that did not arrive.
    pub lost: u64,
    /// Repeated frames.
    pub duplicates: u64,
    /// Frames that a later one overtook.
    pub reordered: u64,
    /// Frames refused for a number far from all others.
    #[serde(default)]
    pub implausible: u64,
    /// Its clock against this host's; absent without an answer.
    #[serde(flatten)]
    pub clock: Option<ClockComparison>,
}

impl Counts {
    pub(crate) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn report(&self, carrier: String, stations: Vec<StationReport>) -> RadioReport {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        RadioReport {
            carrier,
            sent: read(&self.sent),
            not_sent: read(&self.not_sent),
            received: read(&self.received),
            dropped: read(&self.dropped),
            malformed: read(&self.malformed),
            stations,
        }
    }
}

/// All known senders.
#[derive(Debug, Default)]
pub(crate) struct Stations(Vec<Station>);

#[derive(Debug)]
struct Station {
    sender: u64,
    origin: Origin,
    heard: Instant,
    sequence: Sequence,
    clock: Comparison,
    /// True for a roadside unit, which is asked for its clock.
    is_roadside: bool,
    asked: u64,
    ask_at: Instant,
}

impl Stations {
    /// Adds a frame's envelope at `now_ns` by the own wall clock. Returns the sender's clock now; `None` for a
    /// repeated frame.
    pub(crate) fn frame(
        &mut self,
        envelope: &Envelope,
        origin: Origin,
        now_ns: i64,
    ) -> Option<Option<ClockDifference>> {
        let station = self.station(envelope, origin);
        station.heard = Instant::now();
        station.origin = origin;
        let is_new = station.sequence.take(envelope.sequence);
        is_new.then(|| station.clock.difference(now_ns))
    }

    fn station(&mut self, envelope: &Envelope, origin: Origin) -> &mut Station {
        let known = self.0.iter().position(|station| station.sender == envelope.sender);
        let place = known.unwrap_or_else(|| {
            if self.0.len() == NUMBERS.stations as usize {
                let silent = self.0.iter().enumerate().min_by_key(|(_, station)| station.heard);
                let (oldest, _) = silent.expect("the list is full");
                self.0.swap_remove(oldest);
            }
            self.0.push(Station {
                sender: envelope.sender,
                origin,
                heard: Instant::now(),
                sequence: Sequence::default(),
                clock: Comparison::default(),
                is_roadside: envelope.start_ns.is_some(),
                asked: 0,
                ask_at: Instant::now(),
            });
            self.0.len() - 1
        });
        &mut self.0[place]
    }

    /// Takes an answer to a question of ours.
    pub(crate) fn answer(&mut self, sender: u64, exchange: Exchange) {
        if let Some(station) = self.0.iter_mut().find(|station| station.sender == sender) {
            // An answer with impossible stamps is ignored.
            let _ = station.clock.take(exchange);
        }
    }

    /// Destination of the next question, if one is due. Turns follow the monotonic clock.
    pub(crate) fn next_question(&mut self) -> Option<Origin> {
        let now = Instant::now();
        let due = |station: &&mut Station| station.is_roadside && station.ask_at <= now;
        let station = self.0.iter_mut().find(due)?;
        station.asked += 1;
        let first = station.asked < u64::from(NUMBERS.first_questions);
        let period_s = if first { NUMBERS.first_period_s } else { NUMBERS.period_s };
        station.ask_at = now + Duration::from_secs_f64(period_s);
        Some(station.origin)
    }

    /// Time until the next question is due; `None` without one.
    pub(crate) fn until_question(&self) -> Option<Duration> {
        let roadside = self.0.iter().filter(|station| station.is_roadside);
        let due = roadside.map(|station| station.ask_at).min()?;
        Some(due.saturating_duration_since(Instant::now()))
    }

    pub(crate) fn report(&self, now_ns: i64) -> Vec<StationReport> {
        let reports = self.0.iter().map(|station| StationReport {
            sender: format!("{:016x}", station.sender),
            received: station.sequence.received,
            lost: station.sequence.lost(),
            duplicates: station.sequence.duplicates,
            reordered: station.sequence.reordered,
            implausible: station.sequence.implausible,
            clock: station.clock.report(now_ns),
        });
        reports.collect()
    }
}
