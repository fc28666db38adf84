//! The plant's end of `safety/brake`: what acts, and the account of it.

use crate::brake::BrakePath;
use crate::chains::Chains;
use crate::parts::Actuated;
use crate::times::BRAKE_PATH;
use messages::{Brake, BrakeState};
use runtime::report::BrakeFigures;
use runtime::{Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Periods of the emergency brake without a message after which there is none.
const LOST_PERIODS: i64 = 3;

/// What outlives the plant's process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Snapshot {
    path: BrakePath,
    pub(crate) figures: BrakeFigures,
}

/// The emergency brake as the plant has it.
pub(crate) struct Braking {
    topic: Subscriber<Brake>,
    path: BrakePath,
    period_s: f64,
    lost_ns: i64,
    state: BrakeState,
    figures: BrakeFigures,
    chains: Chains,
}

impl Braking {
    /// `None` in a scenario without an emergency brake.
    pub(crate) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        if !scenario.has_aebs() {
            return Ok(None);
        }
        let period_ms = i64::from(scenario.perception.period_ms.value());
        Ok(Some(Self {
            topic: runtime.subscriber()?,
            path: BrakePath::new(scenario),
            period_s: 1e-3 * f64::from(scenario.plant.period_ms.value()),
            lost_ns: LOST_PERIODS * period_ms.max(10) * 1_000_000,
            state: BrakeState::Monitoring,
            figures: BrakeFigures::default(),
            chains: Chains::open(
                i64::from(scenario.aebs.deadline_ms.value()) * 1_000_000,
                BRAKE_PATH,
                runtime.figures(),
            )?,
        }))
    }

    /// Takes the newest request.
    pub(crate) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        runtime.update(&mut self.topic)
    }

    /// Ceiling on the acceleration of a vehicle of acceleration `now_mps2` in this period, m/s².
    pub(crate) fn act(&mut self, release: &Release, now_ns: i64, now_mps2: f64) -> Option<f64> {
        let fresh = self
            .topic
            .newest()
            .filter(|brake| release.scheduled_ns - brake.header.acquisition_ns <= self.lost_ns);
        // Before its first message there is nothing to be missed yet.
        let early = self.topic.newest().is_none() && release.scheduled_ns <= self.lost_ns;
        let state = match fresh {
            Some(brake) => BrakeState::from_wire(brake.state),
            None if early => BrakeState::Monitoring,
            None => BrakeState::Blind,
        };
        let asked_mps2 = fresh.map_or(0.0, |brake| brake.deceleration_mps2);
        if let Some(brake) = fresh {
            let (scheduled_ns, start_ns) = (release.scheduled_ns, release.start_ns);
            self.chains.braked(brake, &Actuated { scheduled_ns, start_ns, now_ns });
        }
        self.count(state);
        self.path.step(release.scheduled_ns.unsigned_abs(), asked_mps2, now_mps2)
    }

    fn count(&mut self, state: BrakeState) {
        let braking = |state| matches!(state, BrakeState::Braking | BrakeState::Holding);
        let figures = &mut self.figures;
        if braking(state) {
            figures.braking_s += self.period_s;
            figures.interventions += u64::from(!braking(self.state));
        }
        let warned = matches!(self.state, BrakeState::Warning) || braking(self.state);
        figures.warnings += u64::from(state == BrakeState::Warning && !warned);
        if state == BrakeState::Blind {
            figures.unavailable_s += self.period_s;
        }
        self.state = state;
    }

    /// What it does now.
    pub(crate) fn state(&self) -> BrakeState {
        self.state
    }

    /// The account.
    pub(crate) fn figures(&self) -> &BrakeFigures {
        &self.figures
    }

    /// Its chains.
    pub(crate) fn chains(&self) -> &Chains {
        &self.chains
    }

    /// What is to outlive this process.
    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot { path: self.path, figures: self.figures.clone() }
    }

    /// Goes on from what another process kept.
    pub(crate) fn restore(&mut self, kept: Snapshot) {
        (self.path, self.figures) = (kept.path, kept.figures);
    }
}
