//! The emergency brake's own path to the wheels, and the account of it.
//!
//! A request acts after the dead time. From then on the path holds the vehicle's acceleration below a ceiling. The
//! ceiling begins at the acceleration of that instant. It falls with the path's jerk to the request, at most to the
//! authority. After the request has ended it rises with the same jerk, until the vehicle's own acceleration is below
//! it. The path is apart from the actuator that the controller commands: the vehicle gets the lower of the two
//! accelerations.

use crate::chains::{BRAKE_PATH, Chains};
use crate::parts::Actuated;
use crate::report::BrakeFigures;
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
    pub(crate) topic: Subscriber<Brake>,
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
            account: Account {
                period_s: 1e-3 * f64::from(scenario.plant.period_ms.value()),
                state: BrakeState::Monitoring,
                figures: BrakeFigures::default(),
            },
            chains: Chains::open(
                i64::from(scenario.aebs.deadline_ms.value()) * 1_000_000,
                BRAKE_PATH,
                runtime.figures(),
            )?,
        }))
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

    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            path: self.path,
            last_radar: self.chains.last_radar,
            figures: self.account.figures.clone(),
        }
    }

    pub(crate) fn restore(&mut self, kept: Snapshot) {
        (self.path, self.account.figures) = (kept.path, kept.figures);
        self.chains.last_radar = kept.last_radar;
    }
}

impl Account {
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

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BrakePath {
    dead_time_ns: u64,
    jerk_mps3: f64,
    authority_mps2: f64,
    period_s: f64,
    asked_since_ns: Option<u64>,
    ceiling_mps2: Option<f64>,
}

impl BrakePath {
    /// The path of a scenario, released.
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let keys = &scenario.aebs;
        Self {
            dead_time_ns: keys.dead_time_ms.nanoseconds(),
            jerk_mps3: keys.jerk_mps3.value(),
            authority_mps2: keys.deceleration_mps2.value(),
            period_s: 1e-3 * f64::from(scenario.plant.period_ms.value()),
            asked_since_ns: None,
            ceiling_mps2: None,
        }
    }

    /// Ceiling on the acceleration, m/s², in the plant's period that starts at `now_ns`; `None` while the path is
    /// released. The vehicle's acceleration is `now_mps2`. A request that is not a positive number is ignored.
    /// Called once in each period.
    pub(crate) fn step(&mut self, now_ns: u64, asked_mps2: f64, now_mps2: f64) -> Option<f64> {
        let asks = asked_mps2 > 0.0;
        self.asked_since_ns = if asks { self.asked_since_ns.or(Some(now_ns)) } else { None };
        let acts = self.asked_since_ns.is_some_and(|since| now_ns - since >= self.dead_time_ns);
        let reach = self.jerk_mps3 * self.period_s;
        self.ceiling_mps2 = if acts {
            let from = self.ceiling_mps2.map_or(now_mps2, |ceiling| ceiling.min(now_mps2));
            Some((from - reach).max(-asked_mps2.min(self.authority_mps2)))
        } else if asks {
            // An earlier ceiling stays while a new request is on its way.
            self.ceiling_mps2
        } else {
            let risen = self.ceiling_mps2.map(|ceiling| ceiling + reach);
            risen.filter(|ceiling| *ceiling < now_mps2.max(0.0) + reach)
        };
        self.ceiling_mps2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use BrakeState::{Blind, Braking, Holding, Monitoring, Warning};

    fn account(states: &[BrakeState]) -> BrakeFigures {
        let mut account =
            Account { period_s: 0.5, state: Monitoring, figures: BrakeFigures::default() };
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

    const PERIOD_NS: u64 = 10_000_000;

    fn path() -> BrakePath {
        let text = "schema_version = 1\nname = \"x\"\n";
        BrakePath::new(&Scenario::parse("x.toml", text).expect("it is right"))
    }

    /// Accelerations over periods of a vehicle that follows the ceiling at once.
    fn drive(path: &mut BrakePath, from: u64, periods: u64, asked: f64, mut now: f64) -> Vec<f64> {
        (from..from + periods)
            .map(|k| {
                now = path.step(k * PERIOD_NS, asked, now).map_or(0.0, |ceiling| ceiling.min(0.0));
                now
            })
            .collect()
    }

    #[test]
    fn it_waits_falls_holds_and_rises() {
        let mut path = path();
        let braking = drive(&mut path, 0, 100, 8.34, 0.0);
        assert!(braking[..10].iter().all(|a| *a == 0.0), "dead time of 0.1 s");
        assert!((braking[10] + 0.1265).abs() < 1e-12);
        let full = braking.iter().position(|a| *a <= -8.34).expect("it is reached");
        assert_eq!(full, 10 + 65, "8.34 / 12.65 = 0.659 s after it began to fall");
        assert_eq!(braking[99], -8.34);
        let released = drive(&mut path, 100, 80, 0.0, -8.34);
        assert!((released[0] + 8.34 - 0.1265).abs() < 1e-12, "it rises from where it was");
        assert!(released.windows(2).all(|pair| (0.0..=0.1266).contains(&(pair[1] - pair[0]))));
        assert_eq!(path.step(200 * PERIOD_NS, 0.0, 0.0), None, "released");
    }

    #[test]
    fn it_begins_where_the_vehicle_is() {
        let mut path = path();
        let braking = drive(&mut path, 0, 11, 8.34, 0.0);
        assert!(braking[9] == 0.0);
        let mut path = self::path();
        for k in 0..10 {
            assert_eq!(path.step(k * PERIOD_NS, 8.34, -4.0), None);
        }
        let first = path.step(10 * PERIOD_NS, 8.34, -4.0).expect("the dead time is over");
        assert!((first + 4.1265).abs() < 1e-12);
    }

    #[test]
    fn no_request_passes_the_authority_and_a_wrong_one_is_dropped() {
        let least = drive(&mut path(), 0, 200, 1e9, 0.0).into_iter().fold(0.0, f64::min);
        assert_eq!(least, -8.34);
        for asked in [f64::NAN, -5.0, f64::NEG_INFINITY, 0.0] {
            assert!((0..100).all(|k| path().step(k * PERIOD_NS, asked, 0.0).is_none()), "{asked}");
        }
    }
}
