//! When to warn, when to brake, when to let go.
//!
//! The ego is beside an object along the road for a time that depends on what it does ([`Plan`]). They touch
//! if the object is in the ego's path in that time, which is a probability: the sum over the lateral speeds
//! that it may have ([`crate::filter`]). To brake shortens the time, or makes it longer where the ego would
//! have passed: the same sums decide both.
//!
//! | state | entered | left |
//! |---|---|---|
//! | [`BrakeState::Monitoring`] | at the start | |
//! | [`BrakeState::Warning`] | as braking, with braking that begins `warning_s` later | no such threat |
//! | [`BrakeState::Braking`] | a contact is likely, braking makes it less likely or milder, and one cycle later it may leave less than the margin | letting go is clear of it, or better than braking on; the ego stands |
//! | [`BrakeState::Holding`] | the ego stands after braking | after [`HOLD_S`] |
//!
//! A contact is likely if it is with the ego's present acceleration. Cruise control and driver brake long
//! before the last point, so that their braking keeps this system silent. Source of the order of warning and
//! braking: UN R152, paragraphs 5.2.1 and 6.4.

use crate::filter::overlap;
use crate::object::Object;
use crate::prediction::{Authority, Beside, Ego, Plan, Threat};
use messages::BrakeState;

/// After a stop the brakes are held for this time, s.
const HOLD_S: f64 = 1.0;
/// A threat that is no longer seen is braked for during this time, s.
const UNSEEN_S: f64 = 0.3;
/// The ego is clear of a threat when, without brakes, it would come no nearer than the margin and this, m.
const CLEAR_M: f64 = 0.5;
/// A pass that leaves less than this behind it counts as a contact, m: as much as its end is uncertain.
const PASS_MARGIN_M: f64 = 1.0;
/// Below this speed the ego stands, m/s.
const STANDSTILL_MPS: f64 = 0.05;
/// Least probability of a contact to brake for, over the closing speed, m/s, linear in between: the milder
/// the contact, the surer it has to be.
const LIKELY: [(f64, f64); 3] = [(0.0, 0.65), (12.0, 0.35), (30.0, 0.2)];
/// Braking is worth while if its expected loss is less than this share of that without.
const BETTER: f64 = 0.6;
/// A contact of this probability is as good as certain: to make it milder is reason enough.
const CERTAIN: f64 = 0.9;
/// A contact of this probability is not to be feared yet: braking can begin later.
const REMOTE: f64 = 0.05;
/// The ego is clear of an object with which a contact is less probable than this.
const CLEAR: f64 = 0.1;
/// An object with which a contact is less probable than this is of no interest.
const NONE: f64 = 0.01;
/// The loss of a contact at this speed difference is twice that of the lightest one, m/s.
const SEVERE_MPS: f64 = 60.0;
/// Lateral motion slower than this may be wandering within the lane, m/s.
const WANDERING_MPS: f64 = 0.8;
/// The slower it is, the sooner it ceases: rate of that at standstill, 1/s.
const CEASES: f64 = 0.6;
/// Something leaves once its middle is this far off the ego's axis, m.
const LEAVING_OFFSET_M: f64 = 0.8;

/// The ego's swept path and how far ahead lateral motion is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Half of the ego's width, m.
    pub half_width_m: f64,
    /// Longest time over which lateral motion is carried on, s.
    pub horizon_s: f64,
}

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
    /// Expected loss without brakes.
    loss: f64,
    warns: bool,
    brakes: bool,
    /// The ego is clear of it without brakes.
    clear: bool,
    threat: (f64, f64, f64),
}

/// A contact as a plan leads to it.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    probability: f64,
    loss: f64,
}

impl Decision {
    /// No threat yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self { settings, state: BrakeState::Monitoring, waited_s: 0.0 }
    }

    /// The ego's swept path.
    #[must_use]
    pub fn path(&self) -> Path {
        self.settings.path
    }

    /// Takes the objects as they are now, once in each period.
    pub fn step(&mut self, ego: &Ego, objects: impl IntoIterator<Item = Object>) -> Demand {
        let braking = self.state == BrakeState::Braking;
        let assess = |object: Object| self.assess(ego, &object, braking);
        let assessments = objects.into_iter().filter_map(assess);
        let (mut worst, mut brakes, mut warns, mut clear) =
            (None::<Assessment>, false, false, true);
        for assessment in assessments {
            brakes |= assessment.brakes;
            warns |= assessment.warns;
            clear &= assessment.clear;
            if worst.is_none_or(|worst| assessment.loss > worst.loss) {
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

    /// `None` for what the ego does not come near to.
    fn assess(&self, ego: &Ego, object: &Object, braking: bool) -> Option<Assessment> {
        let Settings { authority, period_s, margin_m, warning_s, ego_length_m, .. } =
            &self.settings;
        let threat = Threat {
            gap_m: object.distance_m,
            speed_mps: object.speed_mps,
            acceleration_mps2: object.acceleration_mps2,
            passed_m: ego_length_m + object.length_m,
        };
        let steady = Threat { acceleration_mps2: object.acceleration_mps2.min(0.0), ..threat };
        let contact = |threat: &Threat, plan: Plan, clear_m: f64| {
            let beside = authority.beside(ego, threat, plan, clear_m);
            beside.map_or(Contact::default(), |beside| self.contact(object, &beside))
        };
        let mut assessment = Assessment {
            loss: 0.0,
            warns: false,
            brakes: false,
            clear: true,
            threat: (
                object.distance_m,
                object.speed_mps - ego.speed_mps,
                object.lateral.position_m,
            ),
        };
        if braking {
            let near = contact(&steady, Plan::Release, *margin_m + CLEAR_M);
            let passes_better = || {
                let on = contact(&threat, Plan::BrakeOn, 0.0);
                contact(&steady, Plan::Release, 0.0).loss < on.loss
            };
            assessment.loss = near.loss;
            assessment.clear = near.probability <= CLEAR || passes_better();
            return (near.probability > NONE).then_some(assessment);
        }
        let passing = Threat { passed_m: threat.passed_m + PASS_MARGIN_M, ..threat };
        let kept = contact(&passing, Plan::Keep, 0.0);
        assessment.loss = kept.loss;
        if kept.probability < likely(ego.speed_mps - object.speed_mps) {
            return (kept.probability > NONE).then_some(assessment);
        }
        // Each prediction is made only where those before it leave the question open.
        let at = |wait_s: f64, clear_m: f64| contact(&threat, Plan::Brake(wait_s), clear_m);
        let share = if kept.probability > CERTAIN { 1.0 } else { BETTER };
        assessment.brakes =
            at(*period_s, *margin_m).probability > REMOTE && at(0.0, 0.0).loss < share * kept.loss;
        assessment.warns =
            assessment.brakes || at(*period_s + *warning_s, *margin_m).probability > REMOTE;
        Some(assessment)
    }

    /// How probable a contact with `object` is in the time in which the ego is beside it.
    fn contact(&self, object: &Object, beside: &Beside) -> Contact {
        let Path { half_width_m, horizon_s, .. } = self.settings.path;
        let reach_m = half_width_m + object.half_width_m;
        let mut contact = Contact::default();
        for h in object.lateral.hypotheses() {
            let side = h.position_m.signum();
            let inward_mps = -h.rate_mps * side;
            let offset_m = h.position_m.abs();
            // What comes in stays, what leaves is nearest at once.
            let time_s =
                if inward_mps > 0.0 { beside.last_s.min(horizon_s) } else { beside.first_s };
            let moved_m = inward_mps * time_s;
            let then_m = match inward_mps > 0.0 {
                true => (offset_m - moved_m).max(0.0),
                false if offset_m > LEAVING_OFFSET_M => offset_m - moved_m,
                false => offset_m,
            };
            let touches = overlap(reach_m, then_m, h.sigma_after_m(time_s.min(horizon_s)));
            let in_s = if inward_mps > 0.0 { (offset_m - reach_m) / inward_mps } else { 0.0 };
            let wanders = (1.0 - h.rate_mps.abs() / WANDERING_MPS).max(0.0);
            let goes_on = libm::exp(-CEASES * wanders * in_s.max(0.0));
            let probability = object.probability * h.probability * touches * goes_on;
            let closing_mps = beside.closing_mps(in_s);
            contact.probability += probability;
            contact.loss += probability * (1.0 + closing_mps.abs() / SEVERE_MPS);
        }
        contact
    }
}

/// Least probability of a contact to brake for at a closing speed.
fn likely(closing_mps: f64) -> f64 {
    let [slow, middle, fast] = LIKELY;
    let (low, high) = if closing_mps < middle.0 { (slow, middle) } else { (middle, fast) };
    let share = ((closing_mps - low.0) / (high.0 - low.0)).clamp(0.0, 1.0);
    low.1 + share * (high.1 - low.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.05;

    fn settings() -> Settings {
        Settings {
            authority: Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 },
            path: Path { half_width_m: 0.95, horizon_s: 3.0 },
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

    #[test]
    fn a_pass_that_braking_would_turn_into_a_contact_is_not_braked_for() {
        let brakes = |distance_m: f64, lateral_mps: f64| {
            let mut decision = Decision::new(settings());
            let ego = Ego { speed_mps: 25.0, acceleration_mps2: 0.0 };
            let object = Object::at(distance_m, 5.0, 3.5, -lateral_mps, 0.95);
            decision.step(&ego, [object]).state == BrakeState::Braking
        };
        // It is in the way after 1.6 s; the pass takes 1.44 s or, from farther off, longer.
        assert!(!brakes(20.0, 1.0));
        assert!(brakes(27.0, 1.0));
    }

    #[test]
    fn the_faster_the_contact_the_less_sure_it_has_to_be() {
        let at = [0.0, 6.0, 12.0, 21.0, 30.0, 60.0, -5.0].map(likely);
        let expected = [0.65, 0.5, 0.35, 0.275, 0.2, 0.2, 0.65];
        assert!(at.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{at:?}");
    }

    #[test]
    fn what_is_known_vaguely_is_braked_for_when_a_contact_is_likely() {
        let contact = |sigma_m: f64| {
            let decision = Decision::new(settings());
            let mut object = Object::at(20.0, 5.0, 3.5, -0.4, 0.95);
            object.lateral = crate::filter::Lateral::first(3.0, sigma_m);
            let beside = Beside { first_s: 1.0, last_s: 2.0, first_mps: 10.0, last_mps: 10.0 };
            decision.contact(&object, &beside).probability
        };
        assert!(contact(0.05) < 0.2 && contact(0.05) > 0.0);
        assert!(contact(1.0) > contact(0.05), "where it is may be in the way");
    }
}
