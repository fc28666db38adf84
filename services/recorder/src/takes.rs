//! What a recording says of its controller: each cycle with its inputs and its outputs.

use crate::{Record, Recording, Timed};
use messages::rung::Rung;
use messages::{Command, Diagnostics, Origin, Origins, Topic};
use runtime::ScheduledRelease;
use std::collections::{BTreeMap, HashMap};

/// Everything that one process of the controller did, as far as it can be replayed.
#[derive(Clone, Debug, Default)]
pub struct Take {
    /// Which restart of the controller it was.
    pub incarnation: u32,
    /// Its releases, with the samples that each used.
    pub releases: Vec<ScheduledRelease>,
    /// The diagnostics of each release.
    pub diagnostics: Vec<Diagnostics>,
    /// The commands; none in a release in which the controller kept silent.
    pub commands: Vec<Command>,
    /// Why it ends before the process did, if it does.
    pub cut_short: Option<String>,
}

/// Samples by what the controller calls them.
pub(crate) struct Samples<'a>(HashMap<(Topic, Origin), Record<'a>>);

impl<'a> Samples<'a> {
    pub(crate) fn of(recording: &'a Recording) -> Self {
        let inputs = inputs(&Origins::NONE).map(|(topic, _)| topic);
        let records = recording.records().filter(|record| inputs.contains(&record.topic));
        Self(records.map(|record| ((record.topic, Origin::of(&record.header())), record)).collect())
    }

    /// The sample of `topic` that `origin` names.
    pub(crate) fn find(&self, topic: Topic, origin: Origin) -> Option<&Record<'a>> {
        self.0.get(&(topic, origin))
    }
}

/// A release's inputs by topic, in the order in which the controller takes them.
pub(crate) fn inputs(origins: &Origins) -> [(Topic, Origin); 6] {
    [
        (Topic::RadarTracks, origins.radar),
        (Topic::Odometry, origins.odometry),
        (Topic::Spat, origins.spat),
        (Topic::Map, origins.map),
        (Topic::Powertrain, origins.powertrain),
        (Topic::Preview, origins.preview),
    ]
}

impl Recording {
    /// What each process of the controller did, in their order.
    #[must_use]
    pub fn takes(&self) -> Vec<Take> {
        let samples = Samples::of(self);
        let commands: HashMap<(u32, u64), Command> = self
            .messages()
            .map(|timed: Timed<Command>| timed.message)
            .map(|command| ((command.header.incarnation, command.header.step), command))
            .collect();
        let mut takes: BTreeMap<u32, Take> = BTreeMap::new();
        for Timed { message: cycle, .. } in self.messages::<Diagnostics>() {
            let incarnation = cycle.header.incarnation;
            let take =
                takes.entry(incarnation).or_insert_with(|| Take { incarnation, ..Take::default() });
            if take.cut_short.is_none() {
                let command = commands.get(&(incarnation, cycle.header.step));
                take.cut_short = take.add(cycle, command, &samples).err();
            }
        }
        takes.into_values().collect()
    }
}

impl Take {
    /// Adds the next cycle, or says why it cannot be replayed.
    fn add(
        &mut self,
        cycle: Diagnostics,
        command: Option<&Command>,
        samples: &Samples<'_>,
    ) -> Result<(), String> {
        let number = self.diagnostics.len() as u64 + 1;
        if cycle.header.sequence != number {
            return Err(format!("the diagnostics of its cycle {number} were not recorded"));
        }
        if command.is_none() && cycle.rung != Rung::Silent as u32 {
            return Err(format!("the command of its cycle {number} was not recorded"));
        }
        let inputs = inputs(&cycle.header.origins);
        let missing = inputs
            .into_iter()
            .find(|&(topic, origin)| origin.is_some() && samples.find(topic, origin).is_none());
        if let Some((topic, origin)) = missing {
            let (sample, topic) = (origin.sequence, topic.name());
            return Err(format!(
                "message {sample} of `{topic}`, which its cycle {number} used, was not recorded"
            ));
        }
        self.releases.push(ScheduledRelease {
            step: cycle.header.step,
            start_ns: cycle.start_ns,
            publish_ns: command.map_or(cycle.start_ns, |command| command.header.publish_ns),
            inputs: cycle.header.origins,
        });
        self.diagnostics.push(cycle);
        self.commands.extend(command);
        Ok(())
    }
}
