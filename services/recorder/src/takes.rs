//! What a recording says of its controller: each cycle with its inputs and its outputs.

use crate::{Record, Recording};
use shared::messages::{Command, Diagnostics, Header, Origin, Topic};
use shared::runtime::ScheduledRelease;
use std::collections::{BTreeMap, HashMap};

/// Everything that one process of the controller did, as far as it can be replayed.
#[derive(Clone, Debug, Default)]
pub struct Take {
    /// Which restart of the controller it was.
    pub incarnation: u32,
    /// Its releases, with the samples that each used.
    pub releases: Vec<ScheduledRelease>,
    /// The command of each release.
    pub commands: Vec<Command>,
    /// The diagnostics of each release; fewer if the recording lost some.
    pub diagnostics: Vec<Diagnostics>,
    /// Why it ends before the process did, if it does.
    pub cut_short: Option<String>,
}

/// Samples by what commands call them.
pub(crate) struct Samples<'a>(HashMap<(Topic, Origin), Record<'a>>);

impl<'a> Samples<'a> {
    pub(crate) fn of(recording: &'a Recording) -> Self {
        let inputs = [Topic::Odometry, Topic::RadarTracks, Topic::Spat, Topic::Map];
        let records = recording.records().filter(|record| inputs.contains(&record.topic));
        Self(records.map(|record| ((record.topic, Origin::of(&record.header())), record)).collect())
    }

    /// The sample of `topic` that `origin` names.
    pub(crate) fn find(&self, topic: Topic, origin: Origin) -> Option<&Record<'a>> {
        self.0.get(&(topic, origin))
    }
}

/// The inputs of a command by topic, in the order in which the controller takes them.
pub(crate) fn inputs(header: &Header) -> [(Topic, Origin); 4] {
    let origins = &header.origins;
    [
        (Topic::RadarTracks, origins.radar),
        (Topic::Odometry, origins.odometry),
        (Topic::Spat, origins.spat),
        (Topic::Map, origins.map),
    ]
}

impl Recording {
    /// What each process of the controller did, in their order.
    #[must_use]
    pub fn takes(&self) -> Vec<Take> {
        let samples = Samples::of(self);
        let mut takes: BTreeMap<u32, Take> = BTreeMap::new();
        for timed in self.messages::<Command>() {
            let command = timed.message;
            let incarnation = command.header.incarnation;
            let take =
                takes.entry(incarnation).or_insert_with(|| Take { incarnation, ..Take::default() });
            if take.cut_short.is_some() {
                continue;
            }
            let expected = take.commands.len() as u64 + 1;
            if command.header.sequence != expected {
                take.cut_short = Some(format!("its command {expected} was not recorded"));
                continue;
            }
            let missing = inputs(&command.header)
                .into_iter()
                .find(|&(topic, origin)| origin.is_some() && samples.find(topic, origin).is_none());
            if let Some((topic, origin)) = missing {
                take.cut_short = Some(format!(
                    "message {} of `{}`, which its command {expected} used, was not recorded",
                    origin.sequence,
                    topic.name()
                ));
                continue;
            }
            take.releases.push(ScheduledRelease {
                step: command.header.step,
                start_ns: command.start_ns,
                inputs: command.header.origins,
            });
            take.commands.push(command);
        }
        for timed in self.messages::<Diagnostics>() {
            let header = timed.message.header;
            if let Some(take) = takes.get_mut(&header.incarnation)
                && header.sequence <= take.commands.len() as u64
            {
                take.diagnostics.push(timed.message);
            }
        }
        takes.into_values().collect()
    }
}
