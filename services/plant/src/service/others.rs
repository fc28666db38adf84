//! The other vehicles as ground truth has them, from one topic or two.

use messages::{AllVehicles, MAX_TRACKS, MoreVehicles, VehicleTruth};
use runtime::{Runtime, RuntimeError, Subscriber};
use scenario::Scenario;

/// The ports, and the newest step of which all messages have come.
pub(super) struct Others {
    first: Subscriber<VehicleTruth>,
    /// Present in a scenario with more vehicles than the first message has room for.
    more: Option<Subscriber<MoreVehicles>>,
    newest: AllVehicles,
    has_newest: bool,
}

impl Others {
    /// Opens the ports.
    pub(super) fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let has_more = scenario.actors.len() > MAX_TRACKS;
        Ok(Self {
            first: runtime.subscriber()?,
            more: has_more.then(|| runtime.subscriber()).transpose()?,
            newest: AllVehicles::with_room(scenario.actors.len()),
            has_newest: false,
        })
    }

    /// Takes what has come. Between the two messages of a step the step before stays.
    pub(super) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        if let Some(more) = &mut self.more {
            runtime.update(more)?;
        }
        runtime.update(&mut self.first)?;
        let more = self.more.as_ref().map(Subscriber::newest);
        if let (Some(first), None | Some(Some(_))) = (self.first.newest(), more) {
            let is_newer = !self.has_newest || first.header != self.newest.header;
            self.has_newest |= is_newer && self.newest.take(first, more.flatten());
        }
        Ok(())
    }

    /// The newest step.
    pub(super) fn newest(&self) -> Option<&AllVehicles> {
        self.has_newest.then_some(&self.newest)
    }
}
