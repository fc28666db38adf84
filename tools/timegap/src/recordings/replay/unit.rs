//! `timegap replay --of obu`: feeds the recorded frames to the on-board unit again.
//!
//! The unit decodes and checks the frames at the recorded instants with the recorded odometry. Its messages
//! and the vehicle's own frames are compared byte by byte; in a realtime run without publication times.

use super::difference::{Difference, not_compared, places};
use super::{ReplayArguments, ReplayError, scenario};
use crate::recordings::{count, open, print_damage, printable};
use group::{Error, UnitSaid, replay_unit};
use messages::{Map, Message, Place, RadioSent, Service, Spat};
use recorder::{Recording, UnitCycle};
use report::print;
use report::progress::count_bar;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write as _;
use std::process::ExitCode;

/// Cycles kept for late messages of the unit.
const MOST_WAITING: usize = 256;

/// Result of a replay.
#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    scenario: String,
    /// The replayed service.
    replayed: Service,
    /// The recorded run's clock.
    mode: &'static str,
    /// True if the scenario was changed for the replay.
    changed: bool,
    /// Fields that are not compared.
    not_compared: Vec<&'static str>,
    /// Cycles replayed.
    cycles: u64,
    /// Reason for an early end of the replay.
    cut_short: Option<String>,
    /// Messages of the unit, by topic.
    topics: BTreeMap<&'static str, Said>,
    /// True if every compared byte of all messages is equal.
    identical: bool,
    first_difference: Option<Difference>,
    /// Decoded frames, and their verdicts in the replay.
    frames: u64,
    verdicts: BTreeMap<String, u64>,
}

/// Messages of a topic.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Said {
    recorded: u64,
    replayed: u64,
    identical: u64,
}

impl Said {
    fn is_same(self) -> bool {
        self.recorded == self.identical && self.replayed == self.identical
    }
}

/// Runs the command.
pub(super) fn run(arguments: &ReplayArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let (scenario, changed) = scenario(&recording, arguments)?;
    let take = recording.unit_take();
    if take.with_frames == 0 || !scenario.services().contains(&Service::Obu) {
        print_damage(&recording, &recording.survey().damage);
        return Err(ReplayError::NoFrames(recording.path().to_owned()).into());
    }
    let bar = count_bar(usize::try_from(take.cycles).unwrap_or(usize::MAX), arguments.json);
    let mut pairs = Pairs::new(&recording, recording.unit_cycles(&take));
    let report = replay_unit(&scenario, &recording, &take, &mut |said| {
        bar.set_position(pairs.add(&said));
    })?;
    bar.finish_and_clear();
    let (topics, first_difference) = pairs.finish();
    let metadata = recording.metadata();
    let comparison = Comparison {
        schema_version: 1,
        scenario: metadata.scenario_name.clone(),
        replayed: Service::Obu,
        mode: metadata.mode.name(),
        changed,
        not_compared: not_compared(metadata.mode),
        cycles: take.cycles,
        cut_short: take.cut_short,
        identical: topics.values().all(|said| said.is_same()),
        topics,
        first_difference,
        frames: report.frames,
        verdicts: report.verdicts,
    };
    if arguments.json {
        print::out(&(serde_json::to_string_pretty(&comparison).expect("plain data") + "\n"))?;
    } else {
        print::out(&as_text(&comparison))?;
    }
    let damage = recording.survey().damage;
    print_damage(&recording, &damage);
    let is_right = (changed || comparison.identical) && damage.is_empty();
    Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Recorded cycles beside replayed ones during a replay.
struct Pairs<R: Iterator<Item = UnitCycle>> {
    recorded: R,
    waiting: VecDeque<UnitCycle>,
    map: Topic,
    spat: Topic,
    sent: Topic,
    first_difference: Option<Difference>,
}

/// A topic's messages so far, and the compared parts.
struct Topic {
    places: Vec<Place>,
    said: Said,
}

impl Topic {
    fn new<T: Message>(not_compared: &[&str]) -> Self {
        Self { places: places::<T>(not_compared), said: Said::default() }
    }

    fn compare<T: Message>(&mut self, recorded: Option<&T>, replayed: &T) -> Option<Difference> {
        self.said.replayed += 1;
        let difference = Difference::between(&self.places, recorded?, replayed);
        self.said.identical += u64::from(difference.is_none());
        difference
    }
}

impl<R: Iterator<Item = UnitCycle>> Pairs<R> {
    fn new(recording: &Recording, recorded: R) -> Self {
        let not_compared = not_compared(recording.metadata().mode);
        Self {
            recorded,
            waiting: VecDeque::new(),
            map: Topic::new::<Map>(&not_compared),
            spat: Topic::new::<Spat>(&not_compared),
            sent: Topic::new::<RadioSent>(&not_compared),
            first_difference: None,
        }
    }

    /// Compares replayed with recorded messages of the unit; returns the cycles up to here.
    fn add(&mut self, said: &UnitSaid<'_>) -> u64 {
        let step = match said {
            UnitSaid::Map(message) => message.header.step,
            UnitSaid::Spat(message) => message.header.step,
            UnitSaid::Sent(message) => message.header.step,
        };
        let cycle = self.find(step);
        let difference = match said {
            UnitSaid::Map(map) => self.map.compare(cycle.as_ref().map(|cycle| &cycle.map), map),
            UnitSaid::Spat(spat) => {
                self.spat.compare(cycle.as_ref().and_then(|cycle| cycle.spat.as_ref()), spat)
            }
            UnitSaid::Sent(sent) => {
                self.sent.compare(cycle.as_ref().and_then(|cycle| cycle.sent.as_ref()), sent)
            }
        };
        if self.first_difference.is_none() {
            self.first_difference = difference;
        }
        self.map.said.replayed
    }

    /// The recorded cycle of `step`.
    fn find(&mut self, step: u64) -> Option<UnitCycle> {
        while self.waiting.back().is_none_or(|cycle| cycle.map.header.step < step) {
            let Some(cycle) = self.recorded.next() else { break };
            self.count(&cycle);
            if self.waiting.len() == MOST_WAITING {
                self.waiting.pop_front();
            }
            self.waiting.push_back(cycle);
        }
        self.waiting.iter().find(|cycle| cycle.map.header.step == step).cloned()
    }

    fn count(&mut self, cycle: &UnitCycle) {
        self.map.said.recorded += 1;
        self.spat.said.recorded += u64::from(cycle.spat.is_some());
        self.sent.said.recorded += u64::from(cycle.sent.is_some());
    }

    fn finish(mut self) -> (BTreeMap<&'static str, Said>, Option<Difference>) {
        while let Some(cycle) = self.recorded.next() {
            self.count(&cycle);
        }
        let topics = [
            (Map::TOPIC.name(), self.map.said),
            (Spat::TOPIC.name(), self.spat.said),
            (RadioSent::TOPIC.name(), self.sent.said),
        ];
        (topics.into(), self.first_difference)
    }
}

fn as_text(comparison: &Comparison) -> String {
    let c = comparison;
    let mut text = format!("{} · on-board unit · {}\n", printable(&c.scenario), c.mode);
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<14} {value}").expect("a string takes all");
    };
    let frames = count(c.frames, "frame");
    line("replayed", format!("{}, {frames}", count(c.cycles, "cycle")));
    if let Some(why) = &c.cut_short {
        line("CUT SHORT", why.clone());
    }
    let given = c.verdicts.iter().filter(|(_, count)| **count > 0);
    let given = given.map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " ")));
    line("frames", given.collect::<Vec<_>>().join(", "));
    for (topic, said) in &c.topics {
        let Said { recorded, replayed, identical } = *said;
        let value = if said.is_same() {
            format!("all {identical} byte-identical")
        } else if c.changed {
            format!("{identical} of {recorded} byte-identical, {replayed} replayed")
        } else {
            format!("ONLY {identical} of {recorded} BYTE-IDENTICAL, {replayed} replayed")
        };
        line(topic, value);
    }
    if !c.not_compared.is_empty() {
        line("", format!("not compared: {}", c.not_compared.join(", ")));
    }
    if let Some(first) = &c.first_difference {
        line("first", first.to_string());
    }
    text
}
