//! When to warn, when to brake, when to let go.
//!
//! | state | entered | left |
//! |---|---|---|
//! | [`BrakeState::Monitoring`] | at the start | |
//! | [`BrakeState::Warning`] | braking that begins `warning_s` from now would leave less than the margin | no such threat |
//! | [`BrakeState::Braking`] | braking that begins one cycle from now would leave less than the margin | the ego is slower than the threat and clear of it, would pass it where braking makes the contact, or stands |
//! | [`BrakeState::Holding`] | the ego stands after braking | after [`HOLD_S`] |
//!
//! Both need a collision course: with its present acceleration the ego would touch. Cruise control and
//! driver brake long before the last point, so that their braking keeps this system silent. Source of
//! the order of warning and braking: UN R152, paragraphs 5.2.1 and 6.4.

use crate::objects::Object;
use crate::path::Path;
use crate::prediction::{Authority, Ego, Threat};
use messages::BrakeState;

/// After a stop the brakes are held for this time, s.
const HOLD_S: f64 = 1.0;
/// A threat that is no longer seen is braked for during this time, s.
const UNSEEN_S: f64 = 0.3;
/// The ego is clear of a threat when, without brakes, it would come no nearer than the margin and this, m.
const CLEAR_M: f64 = 0.5;
/// Below this speed the ego stands, m/s.
const STANDSTILL_MPS: f64 = 0.05;
/// An object that is not yet in the way counts as coming in when it does so with its lateral motion less by
/// this many standard deviations: to brake for what would have come in behind makes a contact.
const CAUTION_SIGMAS: f64 = 0.8;
/// A wait that never ends, s: longer than any prediction.
const NEVER_S: f64 = 1e3;

/// Settings of the decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What the brakes give.
    pub authority: Authority,
    /// The swept path.
    pub path: Path,
    /// Period of the decision, s.
    pub period_s: f64,
    /// Distance to be left, m.
    pub margin_m: f64,
    /// Time by which the warning comes before the braking, where there is time, s.
    pub warning_s: f64,
    /// Length of the ego, m.
    pub ego_length_m: f64,
}

/// What is asked of the brakes, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// State.
    pub state: BrakeState,
    /// Deceleration, m/s², 0 unless it brakes or holds.
    pub deceleration_mps2: f64,
    /// The threat behind it: gap, m, relative speed, m/s, and lateral offset, m.
    pub threat: Option<(f64, f64, f64)>,
}

/// The decision and its memory.
#[derive(Clone, Debug)]
pub struct Decision {
    settings: Settings,
    state: BrakeState,
    /// Time in [`BrakeState::Holding`], or without a threat while braking, s.
    waited_s: f64,
}

/// What one object demands.
#[derive(Clone, Copy, Debug)]
struct Assessment {
    /// Gap that braking one cycle from now leaves, m.
    left_m: f64,
    warns: bool,
    brakes: bool,
    clear: bool,
    threat: (f64, f64, f64),
}

impl Decision {
    /// No threat yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self { settings, state: BrakeState::Monitoring, waited_s: 0.0 }
    }

    /// Takes the objects as they are now, once in each period.
    pub fn step(&mut self, ego: &Ego, objects: impl IntoIterator<Item = Object>) -> Demand {
        let assess = |object: Object| self.assess(ego, &object);
        let assessments = objects.into_iter().filter_map(assess);
        let (mut worst, mut brakes, mut warns, mut clear) =
            (None::<Assessment>, false, false, true);
        for assessment in assessments {
            brakes |= assessment.brakes;
            warns |= assessment.warns;
            clear &= assessment.clear;
            if worst.is_none_or(|worst| assessment.left_m < worst.left_m) {
                worst = Some(assessment);
            }
        }
        let waited_s = self.waited_s + self.settings.period_s;
        let before = self.state;
        self.state = match before {
            BrakeState::Braking if ego.speed_mps <= STANDSTILL_MPS => BrakeState::Holding,
            BrakeState::Braking if brakes => BrakeState::Braking,
            BrakeState::Braking if worst.is_none() && waited_s < UNSEEN_S => BrakeState::Braking,
            BrakeState::Braking if worst.is_some() && !clear => BrakeState::Braking,
            BrakeState::Holding if waited_s < HOLD_S => BrakeState::Holding,
            _ if brakes => BrakeState::Braking,
            _ if warns => BrakeState::Warning,
            _ => BrakeState::Monitoring,
        };
        let waits =
            self.state == before && !brakes && worst.is_none_or(|_| before == BrakeState::Holding);
        self.waited_s = if waits { waited_s } else { 0.0 };
        let active = matches!(self.state, BrakeState::Braking | BrakeState::Holding);
        let full = self.settings.authority.deceleration_mps2;
        Demand {
            state: self.state,
            deceleration_mps2: if active { full } else { 0.0 },
            threat: worst
                .filter(|_| self.state != BrakeState::Monitoring)
                .map(|worst| worst.threat),
        }
    }

    /// `None` for what is not in the ego's way.
    fn assess(&self, ego: &Ego, object: &Object) -> Option<Assessment> {
        let Settings { authority, path, period_s, margin_m, warning_s, ego_length_m } =
            &self.settings;
        let overlap = path.overlap(object, 0.0)?;
        let threat = Threat {
            gap_m: object.distance_m,
            speed_mps: object.speed_mps,
            acceleration_mps2: object.acceleration_mps2,
            passed_m: ego_length_m + object.length_m,
            overlap,
        };
        let gap_m = |ego: &Ego, threat: &Threat, wait_s: f64| {
            authority.smallest_gap_m(ego, threat, wait_s, *margin_m)
        };
        let coasting = Ego { acceleration_mps2: ego.acceleration_mps2.max(0.0), ..*ego };
        let steady = Threat { acceleration_mps2: object.acceleration_mps2.min(0.0), ..threat };
        let left_m = gap_m(ego, &threat, *period_s);
        let collides = path
            .overlap(object, CAUTION_SIGMAS)
            .is_some_and(|overlap| gap_m(ego, &Threat { overlap, ..threat }, NEVER_S) < 0.0);
        // Braking does not avoid it, and without braking it is passed before it is in the way.
        let passes = left_m < 0.0 && gap_m(&coasting, &steady, NEVER_S) == f64::INFINITY;
        let is_behind = object.speed_mps >= ego.speed_mps
            && gap_m(&coasting, &steady, NEVER_S) > *margin_m + CLEAR_M;
        Some(Assessment {
            left_m,
            warns: collides && gap_m(ego, &threat, *period_s + *warning_s) < *margin_m,
            brakes: collides && left_m < *margin_m,
            clear: passes || is_behind,
            threat: (
                object.distance_m,
                object.speed_mps - ego.speed_mps,
                object.lateral.position_m,
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.05;

    fn settings() -> Settings {
        Settings {
            authority: Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 },
            path: Path { half_width_m: 0.95, horizon_s: 3.0, least_lateral_mps: 0.1 },
            period_s: PERIOD_S,
            margin_m: 0.6,
            warning_s: 0.8,
            ego_length_m: 4.5,
        }
    }

    /// Drives at `speed` towards something of `other` m/s at `gap`; returns the states with the times
    /// at which they were entered and the last gap.
    fn drive(speed: f64, other: f64, gap: f64) -> (Vec<(f64, BrakeState)>, f64) {
        let mut decision = Decision::new(settings());
        let (mut v, mut a, mut d, mut asked_s) = (speed, 0.0_f64, gap, 0.0);
        let mut states = Vec::new();
        for k in 0..2000 {
            let t = f64::from(k) * 0.01;
            if k % 5 == 0 {
                let object = Object::at(d, other, 0.0, 0.0, 0.95);
                let ego = Ego { speed_mps: v, acceleration_mps2: a };
                let demand = decision.step(&ego, [object]);
                if states.last().is_none_or(|last: &(f64, BrakeState)| last.1 != demand.state) {
                    states.push((t, demand.state));
                }
                asked_s = if demand.deceleration_mps2 > 0.0 { asked_s + 0.05 } else { 0.0 };
            }
            a = if asked_s > 0.1 { (a - 0.1265).max(-8.3385) } else { (a + 0.1265).min(0.0) };
            let next = (v + a * 0.01).max(0.0);
            d += 0.01 * (other - 0.5 * (v + next));
            v = next;
        }
        (states, d)
    }

    #[test]
    fn it_warns_then_brakes_then_holds_short_of_what_stands() {
        let (states, gap) = drive(20.0, 0.0, 100.0);
        let order: Vec<BrakeState> = states.iter().map(|(_, state)| *state).collect();
        let expected =
            [BrakeState::Monitoring, BrakeState::Warning, BrakeState::Braking, BrakeState::Holding];
        assert_eq!(order[..4], expected, "{states:?}");
        assert!(states[2].0 - states[1].0 >= 0.75, "{states:?}");
        assert!((0.0..2.0).contains(&gap), "it stops at {gap} m");
    }

    #[test]
    fn it_lets_go_once_the_other_is_faster() {
        let (states, gap) = drive(30.0, 15.0, 80.0);
        assert!(states.iter().any(|(_, state)| *state == BrakeState::Braking), "{states:?}");
        assert_eq!(states.last().map(|last| last.1), Some(BrakeState::Monitoring), "{states:?}");
        assert!(gap > 0.0);
    }

    #[test]
    fn an_ego_that_brakes_enough_by_itself_is_left_alone() {
        let mut decision = Decision::new(settings());
        // 20 m/s needs 5 m/s² in 40 m.
        let ego = Ego { speed_mps: 20.0, acceleration_mps2: -5.2 };
        let object = Object::at(40.0, 0.0, 0.0, 0.0, 0.95);
        let demand = decision.step(&ego, [object]);
        assert_eq!(demand.state, BrakeState::Monitoring);
    }

    #[test]
    fn a_stop_behind_a_standing_car_at_walking_pace_is_left_alone() {
        let mut decision = Decision::new(settings());
        for gap in [3.0, 2.0, 1.5] {
            let ego = Ego { speed_mps: 0.8, acceleration_mps2: -0.5 };
            let object = Object::at(gap, 0.0, 0.0, 0.0, 0.95);
            let demand = decision.step(&ego, [object]);
            assert_eq!(demand.state, BrakeState::Monitoring, "{gap} m");
        }
    }

    #[test]
    fn what_is_passed_before_it_comes_in_is_left_alone() {
        let brakes = |gap_m: f64, lateral_mps: f64| {
            let mut decision = Decision::new(settings());
            let ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };
            let object = Object::at(gap_m, 5.0, 3.4, -lateral_mps, 0.95);
            decision.step(&ego, [object]).state == BrakeState::Braking
        };
        // 5 + 8.8 m at 15 m/s take 0.92 s, the 1.5 m to the ego's side 1.5 s or 0.8 s.
        assert!(!brakes(5.0, 1.0));
        assert!(brakes(5.0, 1.9));
        // 18 m at 15 m/s: it is in the way when the ego is there, and this is the last point.
        assert!(brakes(18.0, 1.0));
        assert!(!brakes(40.0, 1.0), "later will do");
    }
}
