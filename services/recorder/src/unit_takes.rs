//! An on-board unit's part of a recording: each cycle with the frames that it decoded, and the results. It is read in
//! one pass over the file and in bounded memory.

use crate::takes::Window;
use crate::{Record, Recording, Records};
use messages::{Header, Map, Message, Origin, RadioSent, Service, Spat, Topic};
use runtime::ScheduledRelease;
use std::collections::VecDeque;
use std::sync::Arc;

/// Cycles behind which nothing of a cycle is recorded any more.
const MOST_WAITING: usize = 64;

const RECORDED: [Topic; 5] =
    [Topic::RadioFrames, Topic::Odometry, Topic::Map, Topic::Spat, Topic::RadioSent];

/// Work of the on-board unit, as far as it can be replayed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnitTake {
    /// Its cycles.
    pub cycles: u64,
    /// Cycles among them that name a batch of frames.
    pub with_frames: u64,
    /// Reason why it ends before the run did, if it does.
    pub cut_short: Option<String>,
}

/// One cycle of the on-board unit.
#[derive(Clone, Debug)]
pub struct UnitCycle {
    /// The stop lines that it sent.
    pub map: Map,
    /// Their signals; none where that was not recorded.
    pub spat: Option<Spat>,
    /// The vehicle's own frame, if one was due.
    pub sent: Option<RadioSent>,
    /// The batch of frames that it decoded last; `None` without one, or if it was not recorded.
    pub frames: Option<Arc<[u8]>>,
    /// The odometry that it used, likewise.
    pub odometry: Option<Arc<[u8]>>,
}

impl UnitCycle {
    /// The batch of frames that it used.
    #[must_use]
    pub fn batch(&self) -> Origin {
        self.map.header.origins.spat
    }

    /// The release, to be scheduled again.
    #[must_use]
    pub fn release(&self) -> ScheduledRelease {
        let header = &self.map.header;
        ScheduledRelease {
            step: header.step,
            start_ns: header.acquisition_ns,
            publish_ns: header.publish_ns,
            inputs: header.origins,
        }
    }

    /// Reason why it cannot be replayed as cycle `number` of the unit, counted from 1.
    fn gap(&self, number: u64) -> Option<String> {
        let header = &self.map.header;
        if header.incarnation > 0 {
            return Some(
                "it was started again, and received frames before its first message".into(),
            );
        }
        let missing = |message: u64, topic: Topic| {
            format!(
                "message {message} of `{}`, of its cycle {number}, was not recorded",
                topic.name()
            )
        };
        if header.sequence != number {
            return Some(missing(number, Topic::Map));
        }
        if self.spat.is_none() {
            return Some(missing(number, Topic::Spat));
        }
        if self.batch().is_some() && self.frames.is_none() {
            return Some(missing(self.batch().sequence, Topic::RadioFrames));
        }
        let odometry = header.origins.odometry;
        (odometry.is_some() && self.odometry.is_none())
            .then(|| missing(odometry.sequence, Topic::Odometry))
    }
}

impl Recording {
    /// Work of the on-board unit.
    #[must_use]
    pub fn unit_take(&self) -> UnitTake {
        let mut take = UnitTake::default();
        for cycle in UnitCycles::of(self.records_of(&RECORDED)) {
            take.cut_short = cycle.gap(take.cycles + 1);
            if take.cut_short.is_some() {
                break;
            }
            take.cycles += 1;
            take.with_frames += u64::from(cycle.batch().is_some());
        }
        take
    }

    /// The cycles of `take`, in their order.
    pub fn unit_cycles(&self, take: &UnitTake) -> impl Iterator<Item = UnitCycle> + use<> {
        let count = usize::try_from(take.cycles).unwrap_or(usize::MAX);
        UnitCycles::of(self.records_of(&RECORDED)).take(count)
    }
}

/// The cycles of the on-board unit. A group without an on-board unit does not have them: there the roadside unit sends
/// the same topics.
struct UnitCycles {
    records: Records,
    frames: Window,
    odometry: Window,
    maps: VecDeque<Map>,
    spats: VecDeque<Spat>,
    sent: VecDeque<RadioSent>,
    is_at_end: bool,
}

impl UnitCycles {
    fn of(records: Records) -> Self {
        Self {
            records,
            frames: Window::default(),
            odometry: Window::default(),
            maps: VecDeque::new(),
            spats: VecDeque::new(),
            sent: VecDeque::new(),
            is_at_end: false,
        }
    }

    fn take_in(&mut self, record: &Record) {
        let header = record.header();
        let is_of_unit = header.source == Service::Obu.to_wire();
        match record.topic {
            Topic::RadioFrames => self.frames.push(Origin::of(&header), record.bytes()),
            Topic::Odometry => self.odometry.push(Origin::of(&header), record.bytes()),
            Topic::Map if is_of_unit => self.maps.extend(record.message::<Map>()),
            Topic::Spat if is_of_unit => self.spats.extend(record.message::<Spat>()),
            Topic::RadioSent => self.sent.extend(record.message::<RadioSent>()),
            _ => {}
        }
    }
}

/// Takes the message of a process's step out of `waiting`, and those before it.
fn of_step<T: Message>(waiting: &mut VecDeque<T>, map: &Header) -> Option<T> {
    let key = |header: &Header| (header.incarnation, header.step);
    while waiting.front().is_some_and(|message| key(message.header()) < key(map)) {
        waiting.pop_front();
    }
    match waiting.front() {
        Some(message) if key(message.header()) == key(map) => waiting.pop_front(),
        _ => None,
    }
}

impl Iterator for UnitCycles {
    type Item = UnitCycle;

    fn next(&mut self) -> Option<UnitCycle> {
        // In simulated time nothing takes time: what belongs to a cycle may stand before or behind it.
        while !self.is_at_end && self.maps.len() < MOST_WAITING {
            match self.records.next() {
                Some(record) => self.take_in(&record),
                None => self.is_at_end = true,
            }
        }
        let map = self.maps.pop_front()?;
        let header = &map.header;
        Some(UnitCycle {
            spat: of_step(&mut self.spats, header),
            sent: of_step(&mut self.sent, header),
            frames: self.frames.find(header.origins.spat, false),
            odometry: self.odometry.find(header.origins.odometry, false),
            map,
        })
    }
}
