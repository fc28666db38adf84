//! The plant's end of `safety/brake`: what acts, and the account of it.

use crate::brake::BrakePath;
use crate::chains::Chains;
use crate::parts::Actuated;
use crate::report::BrakeFigures;
use crate::times::BRAKE_PATH;
use messages::{Brake, BrakeState, Origin};
use runtime::{Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Periods of the emergency brake without a message after which its last request ends. Chosen: two lost messages are
/// chance.
const LOST_PERIODS: i64 = 3;

/// State that outlives the plant's process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Snapshot {
    path: BrakePath,
    last_radar: Option<Origin>,
    pub(crate) figures: BrakeFigures,
}

/// The emergency brake as the plant has it.
pub(crate) struct Braking {
    topic: Subscriber<Brake>,
    path: BrakePath,
    lost_ns: i64,
    pub(crate) account: Account,
    pub(crate) chains: Chains,
}

/// Actions of the emergency brake so far, counted in each period.
pub(crate) struct Account {
    period_s: f64,
    pub(crate) state: BrakeState,
    pub(crate) figures: BrakeFigures,
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
            lost_ns: LOST_PERIODS * period_ms.max(10) * 1_000_000,
            account: Account::new(1e-3 * f64::from(scenario.plant.period_ms.value())),
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
        self.account.count(state);
        self.path.step(release.scheduled_ns.unsigned_abs(), asked_mps2, now_mps2)
    }

    /// State that outlives this process.
    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            path: self.path,
            last_radar: self.chains.last_radar(),
            figures: self.account.figures.clone(),
        }
    }

    /// Goes on from what another process kept.
    pub(crate) fn restore(&mut self, kept: Snapshot) {
        (self.path, self.account.figures) = (kept.path, kept.figures);
        self.chains.restore(kept.last_radar);
    }
}

impl Account {
    fn new(period_s: f64) -> Self {
        Self { period_s, state: BrakeState::Monitoring, figures: BrakeFigures::default() }
    }

    /// Counts one period in `state`.
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use BrakeState::{Blind, Braking, Holding, Monitoring, Warning};

    fn account(states: &[BrakeState]) -> BrakeFigures {
        let mut account = Account::new(0.5);
        for state in states {
            account.count(*state);
            assert_eq!(account.state, *state);
        }
        account.figures
    }

    #[test]
    fn an_intervention_lasts_from_the_first_braking_period_to_the_last_held_one() {
        let figures = account(&[Warning, Braking, Braking, Holding, Monitoring, Braking, Blind]);
        assert_eq!((figures.interventions, figures.warnings), (2, 1));
        assert_eq!((figures.braking_s, figures.unavailable_s), (2.0, 0.5));
    }

    #[test]
    fn a_warning_counts_once_and_not_on_the_way_out_of_braking() {
        let figures =
            account(&[Warning, Warning, Monitoring, Warning, Braking, Warning, Holding, Warning]);
        assert_eq!((figures.interventions, figures.warnings), (2, 2));
        assert_eq!(account(&[Monitoring, Monitoring]), BrakeFigures::default());
        assert_eq!(account(&[Blind, Blind, Monitoring]).unavailable_s, 1.0);
    }
}
