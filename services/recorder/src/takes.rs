//! A controller's part of a recording: each cycle with its inputs and its outputs. It takes one pass over the file and
//! bounded memory.

use crate::{Record, Recording, Records};
use messages::level::Level;
use messages::{Command, Diagnostics, Origin, Origins, Topic};
use runtime::ScheduledRelease;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// Most bytes of one topic's samples that are kept for cycles to come: at 1 kHz, seconds.
const WINDOW_BYTES: usize = 8 << 20;
/// Most cycles that wait for a message that is recorded behind them, as after a fault of a clock.
const MOST_WAITING: usize = 1024;

/// Work of one process of the controller, as far as it can be replayed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Take {
    pub incarnation: u32,
    pub cycles: u64,
    /// Commands among them: none in a cycle in which the controller kept silent.
    pub commands: u64,
    /// Reason why it ends before the process did, if it does.
    pub cut_short: Option<String>,
}

#[derive(Clone, Debug)]
pub struct Cycle {
    /// Its own description.
    pub diagnostics: Diagnostics,
    pub command: Option<Command>,
    /// The samples that it used, by the topics of [`INPUTS`]. `None` where it used none, or where it was not recorded.
    pub samples: [Option<Arc<[u8]>>; INPUTS.len()],
}

/// The controller's inputs, in the order in which it takes them.
pub const INPUTS: [Topic; 9] = [
    Topic::RadarTracks,
    Topic::Odometry,
    Topic::Spat,
    Topic::Map,
    Topic::Powertrain,
    Topic::Preview,
    Topic::Course,
    Topic::Curves,
    Topic::LateralMotion,
];

/// The samples that a message was computed from, by the topics of [`INPUTS`].
pub fn inputs(origins: &Origins) -> [Origin; INPUTS.len()] {
    let o = origins;
    [o.radar, o.odometry, o.spat, o.map, o.powertrain, o.preview, o.radar, o.preview, o.odometry]
}

/// True if the sample at `index` of [`INPUTS`] was used and is not there.
fn is_missing(index: usize, origin: Origin, samples: &[Option<Arc<[u8]>>; INPUTS.len()]) -> bool {
    // One that rides exists on a road with a plan alone. A topic that rides with another one, as the map of curves for
    // a car, has that topic's place.
    let rides_here = |other: usize| INPUTS[other].rides_with() == Some(INPUTS[index]);
    let stands_for = (0..INPUTS.len()).any(|other| rides_here(other) && samples[other].is_some());
    origin.is_some()
        && samples[index].is_none()
        && INPUTS[index].rides_with().is_none()
        && !(INPUTS[index] == Topic::Preview && stands_for)
}

impl Cycle {
    pub fn release(&self) -> ScheduledRelease {
        let start_ns = self.diagnostics.start_ns;
        ScheduledRelease {
            step: self.diagnostics.header.step,
            start_ns,
            publish_ns: self.command.as_ref().map_or(start_ns, |command| command.header.publish_ns),
            inputs: self.diagnostics.header.origins,
        }
    }

    /// Reason why it cannot be replayed as cycle `number` of its process, counted from 1.
    fn gap(&self, number: u64) -> Option<String> {
        let cycle = &self.diagnostics;
        if cycle.header.sequence != number {
            return Some(format!("the diagnostics of its cycle {number} were not recorded"));
        }
        if self.command.is_none() && cycle.rung != Level::Silent as u32 {
            return Some(format!("the command of its cycle {number} was not recorded"));
        }
        let origins = inputs(&cycle.header.origins);
        let is_missing = |&index: &usize| is_missing(index, origins[index], &self.samples);
        let index = (0..INPUTS.len()).find(is_missing)?;
        let (sample, topic) = (origins[index].sequence, INPUTS[index].name());
        Some(format!(
            "message {sample} of `{topic}`, which its cycle {number} used, was not recorded"
        ))
    }
}

impl Recording {
    /// Work of each process of the controller, in their order.
    pub fn takes(&self) -> Vec<Take> {
        let mut takes: BTreeMap<u32, Take> = BTreeMap::new();
        for cycle in Cycles::of(self) {
            let incarnation = cycle.diagnostics.header.incarnation;
            let take =
                takes.entry(incarnation).or_insert_with(|| Take { incarnation, ..Take::default() });
            if take.cut_short.is_none() {
                take.cut_short = cycle.gap(take.cycles + 1);
                if take.cut_short.is_none() {
                    take.cycles += 1;
                    take.commands += u64::from(cycle.command.is_some());
                }
            }
        }
        takes.into_values().collect()
    }

    /// The cycles of `take`, in their order.
    pub fn cycles(&self, take: &Take) -> impl Iterator<Item = Cycle> + use<> {
        let (incarnation, count) = (take.incarnation, take.cycles);
        Cycles::of(self)
            .filter(move |cycle| cycle.diagnostics.header.incarnation == incarnation)
            .take(usize::try_from(count).unwrap_or(usize::MAX))
    }
}

/// The cycles of all processes of the controller, in the order of their diagnostics.
struct Cycles {
    records: Records,
    samples: [Window; INPUTS.len()],
    commands: VecDeque<Command>,
    waiting: VecDeque<Diagnostics>,
    is_at_end: bool,
}

impl Cycles {
    fn of(recording: &Recording) -> Self {
        let topics = [&INPUTS[..], &[Topic::Command, Topic::Diagnostics]].concat();
        Self {
            records: recording.records_of(&topics),
            samples: Default::default(),
            commands: VecDeque::new(),
            waiting: VecDeque::new(),
            is_at_end: false,
        }
    }

    fn take_in(&mut self, record: &Record) {
        if let Some(index) = INPUTS.iter().position(|topic| *topic == record.topic) {
            self.samples[index].push(Origin::of(&record.header()), record.bytes());
        } else if let Some(command) = record.message() {
            self.commands.push_back(command);
            if self.commands.len() > 2 * MOST_WAITING {
                self.commands.pop_front();
            }
        } else if let Some(diagnostics) = record.message() {
            self.waiting.push_back(diagnostics);
        }
    }

    /// The cycle that waits longest, as far as it was recorded up to here, and whether that is all.
    fn first(&mut self) -> Option<(Cycle, bool)> {
        let diagnostics = *self.waiting.front()?;
        let key = (diagnostics.header.incarnation, diagnostics.header.step);
        let of_cycle =
            |command: &&Command| (command.header.incarnation, command.header.step) == key;
        let command = self.commands.iter().rev().find(of_cycle).copied();
        let origins = inputs(&diagnostics.header.origins);
        let mut is_whole = command.is_some() || diagnostics.rung == Level::Silent as u32;
        let mut samples = [const { None }; INPUTS.len()];
        let windows = self.samples.iter_mut().zip(INPUTS);
        for (((window, topic), origin), sample) in windows.zip(origins).zip(&mut samples) {
            *sample = window.find(origin, topic.rides_with().is_some());
        }
        is_whole &= !(0..INPUTS.len()).any(|index| is_missing(index, origins[index], &samples));
        Some((Cycle { diagnostics, command, samples }, is_whole))
    }
}

impl Iterator for Cycles {
    type Item = Cycle;

    fn next(&mut self) -> Option<Cycle> {
        loop {
            // Only the first of those that wait is looked at: a gap is found once, not at each message.
            let is_due = self.is_at_end || self.waiting.len() > MOST_WAITING;
            if let Some((cycle, is_whole)) = self.first()
                && (is_whole || is_due)
            {
                self.waiting.pop_front();
                return Some(cycle);
            }
            if self.is_at_end {
                return None;
            }
            match self.records.next() {
                Some(record) => self.take_in(&record),
                None => self.is_at_end = true,
            }
        }
    }
}

/// The newest samples of a topic, and the one that was used last, however old.
#[derive(Default)]
struct Window {
    samples: VecDeque<(Origin, Arc<[u8]>)>,
    bytes: usize,
    used: Option<(Origin, Arc<[u8]>)>,
}

impl Window {
    fn push(&mut self, origin: Origin, bytes: &[u8]) {
        self.samples.push_back((origin, bytes.into()));
        self.bytes += bytes.len();
        while self.bytes > WINDOW_BYTES
            && let Some((_, oldest)) = self.samples.pop_front()
        {
            self.bytes -= oldest.len();
        }
    }

    /// The sample that `origin` means ([`Origin::means`]).
    fn find(&mut self, origin: Origin, rides: bool) -> Option<Arc<[u8]>> {
        if !origin.is_some() {
            return None;
        }
        let is_it = |sample: &&(Origin, Arc<[u8]>)| origin.means(&sample.0, rides);
        let found = self.used.as_ref().filter(is_it);
        let found = found.or_else(|| self.samples.iter().rev().find(is_it)).cloned();
        if found.is_some() {
            self.used.clone_from(&found);
        }
        found.map(|(_, bytes)| bytes)
    }
}
