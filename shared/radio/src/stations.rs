//! Known senders with their numbers and clocks.

use crate::clock::{ClockDifference, Comparison, Exchange};
use crate::counts::StationReport;
use crate::endpoint::Origin;
use crate::envelope::Envelope;
use crate::numbers::NUMBERS;
use crate::sequence::Sequence;
use std::time::{Duration, Instant};

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
