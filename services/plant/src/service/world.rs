//! The ground truth of others and signals, and the verdicts on the ego among them.

use messages::{AllVehicles, EgoTruth, MAX_TRACKS, MoreVehicles, SignalTruth, VehicleTruth};
use runtime::{Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;

use super::plane::Plane;
use crate::clear::ClearWatch;
use crate::longitudinal::State;
use crate::numbers::Numbers;
use crate::referee::{self, Referee, Violation};
use crate::surroundings::Surroundings;

/// The ports, and what judges by them.
pub(super) struct World {
    vehicles: Subscriber<VehicleTruth>,
    /// Present in a scenario with more vehicles than the first message has room for.
    more: Option<Subscriber<MoreVehicles>>,
    /// The newest step of which all messages have come.
    newest: AllVehicles,
    has_newest: bool,
    signals: Subscriber<SignalTruth>,
    surroundings: Surroundings,
    pub(super) referee: Referee,
    /// Set in a run that ends when the ego is clear of all others.
    clear: Option<ClearWatch>,
}

impl World {
    pub(super) fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Ok(Self {
            vehicles: runtime.subscriber()?,
            more: (scenario.actors.len() > MAX_TRACKS).then(|| runtime.subscriber()).transpose()?,
            newest: AllVehicles::with_room(scenario.actors.len()),
            has_newest: false,
            signals: runtime.subscriber()?,
            surroundings: Surroundings::new(scenario, &Numbers::DEFAULT),
            referee: Referee::new(scenario, &Numbers::DEFAULT),
            clear: ClearWatch::of(scenario),
        })
    }

    /// Takes what has come. Between the two messages of a step the step before stays.
    pub(super) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        if let Some(more) = &mut self.more {
            runtime.update(more)?;
        }
        runtime.update(&mut self.vehicles)?;
        let more = self.more.as_ref().map(Subscriber::newest);
        if let (Some(first), None | Some(Some(_))) = (self.vehicles.newest(), more) {
            let is_newer = !self.has_newest || first.header != self.newest.header;
            self.has_newest |= is_newer && self.newest.take(first, more.flatten());
        }
        runtime.update(&mut self.signals)
    }

    pub(super) fn vehicles(&self) -> Option<&AllVehicles> {
        self.has_newest.then_some(&self.newest)
    }

    pub(super) fn signals(&self) -> Option<&SignalTruth> {
        self.signals.newest()
    }

    pub(super) fn around(&mut self, release: &Release, ego: &State) -> EgoTruth {
        let vehicles = self.has_newest.then_some(&self.newest);
        self.surroundings.of(ego, release.time_s, vehicles, self.signals.newest())
    }

    pub(super) fn judge(
        &mut self,
        release: &Release,
        ego: &State,
        plane: Option<&Plane>,
    ) -> Option<Violation> {
        let vehicles = self.has_newest.then_some(&self.newest);
        let ahead = vehicles.and_then(|newest| {
            self.surroundings.lengths.ahead(newest, ego.position_m, release.time_s)
        });
        let now_ns = release.scheduled_ns.unsigned_abs();
        let in_plane = plane.map(|plane| plane.sample(release, ego, vehicles));
        let shown = self.signals.newest().into_iter().flat_map(referee::SignalTruth::all);
        self.referee.observe(now_ns, ego, ahead.as_ref(), shown, in_plane.as_ref())
    }

    /// True if the run ends because the ego is clear of all others.
    pub(super) fn is_clear(&mut self, release: &Release, ego: &State) -> bool {
        let vehicles = self.has_newest.then_some(&self.newest);
        let (Some(clear), Some(others)) = (&mut self.clear, vehicles) else { return false };
        clear.observe(release.scheduled_ns, ego, others)
    }
}
