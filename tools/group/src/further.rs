//! The second message of a step's vehicles, for those for which the first has no room.

use messages::{AllVehicles, MAX_TRACKS, MoreVehicles};
use runtime::{Observed, Observer, RuntimeError};

use crate::report::ReceivedTopic;

/// The topic of a scenario with many vehicles, and its messages that wait for the first ones of their steps.
#[derive(Debug)]
pub(crate) struct Further {
    topic: Observed<MoreVehicles>,
    waiting: Vec<MoreVehicles>,
}

impl Further {
    /// Opens the topic; `None` where the first messages have room for all `others`.
    pub(crate) fn listen(observer: &Observer, others: usize) -> Result<Option<Self>, RuntimeError> {
        let has_more = others > MAX_TRACKS;
        let topic = has_more.then(|| observer.listen()).transpose()?;
        Ok(topic.map(|topic| Self { topic, waiting: Vec::new() }))
    }

    /// Puts the messages that arrived to the first ones of their steps. A second message is sent before the first one:
    /// those of later steps wait for theirs.
    pub(crate) fn join(&mut self, truths: &mut [AllVehicles]) -> Result<(), RuntimeError> {
        let Self { topic, waiting } = self;
        topic.drain(|message| waiting.push(*message))?;
        waiting.retain(|more| !join(truths, more));
        Ok(())
    }

    /// Count of received messages.
    pub(crate) fn received(&self) -> ReceivedTopic {
        self.topic.received()
    }
}

/// Puts further vehicles to the first ones of their step; false if these are still to come.
fn join(truths: &mut [AllVehicles], more: &MoreVehicles) -> bool {
    let step = more.header.step;
    let first = truths.iter_mut().rev().find(|truth| truth.header.step <= step);
    let found = first.filter(|truth| truth.header.step == step);
    let is_found = found.is_some();
    if let Some(first) = found {
        first.vehicles.extend_from_slice(more.listed());
    }
    is_found || truths.last().is_some_and(|last| last.header.step > step)
}
