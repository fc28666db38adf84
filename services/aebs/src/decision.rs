//! When to warn, when to brake, when to let go.
//!
//! The ego is beside an object along the road for a time that depends on when it brakes ([`Authority::beside`]). They
//! touch if the object is in the ego's path in that time. The probability of this is a sum over the lateral speeds that
//! the object may have ([`crate::filter`]). To brake shortens the time, or makes it longer where the ego would have
//! passed: the same sums decide both.
//!
//! | state | entered | left |
//! |---|---|---|
//! | [`BrakeState::Monitoring`] | at the start | |
//! | [`BrakeState::Warning`] | as braking, with braking that begins `warning_s` later | no such threat |
//! | [`BrakeState::Braking`] | in two scans a contact is likely, braking makes it less likely or milder, and one cycle later it may leave less than the margin | letting go is safe; the ego stands |
//! | [`BrakeState::Holding`] | the ego stands after braking | after [`HOLD_S`] |
//!
//! The margin is computed with less than the brakes' authority ([`COUNTED_ON_MPS2`]): a lead, which moves in the path, may
//! begin to brake with [`LEAD_MAY_BRAKE_MPS2`]. If a driver's braking ([`ANSWER_MPS2`]) is no longer enough then, the whole
//! authority must still leave the margin when that is noticed ([`NOTICES_S`]).
//!
//! Letting go is safe if two things hold. Without brakes the ego comes no nearer than the margin and [`CLEAR_M`]. And if
//! the other vehicle goes on as it does, braking anew leaves the margin.
//!
//! Braking for an oncoming vehicle begins when the contact would otherwise be harder.
//!
//! To brake for nothing costs something too: who follows may not stop in time. A contact is likely where the expected
//! cost of not braking is the greater one:
//!
//! ```text
//! P (c + Δv) > (1 - P) (c + f)          P: probability of the contact, Δv: closing speed
//!                                       c: cost of any contact at all, f: closing speed of a contact
//! P > (c + f) / (2 c + f + Δv)             that is as bad as braking for nothing
//! ```
//!
//! P is that with the ego's present acceleration. Cruise control and driver brake long before the last point, so that
//! their braking keeps this system silent. Source of the order of warning and braking: UN R152, paragraphs 5.2.1, 6.4.

use crate::filter::overlap;
use crate::object::{Object, WIDTH_M};
use crate::prediction::{Authority, Beside, Ego, NEVER_S, Threat};
use messages::BrakeState;

/// Time for which the brakes are held after a stop, s. Chosen: the driver has that time to take over.
const HOLD_S: f64 = 1.0;
/// Time for which the brake acts on a threat that is no longer seen, s. Chosen: six scans of 50 ms.
const UNSEEN_S: f64 = 0.3;
/// Deceleration that the last point counts on, m/s². Chosen: braking that any dry road gives.
const COUNTED_ON_MPS2: f64 = 6.0;
/// Braking of driver and law with which nothing need be kept in reserve for a lead, m/s². Chosen: as hard as the
/// plant's own stop in lane. A fifth more: 1 avoidable collision in 300 random drives instead of 0.
const ANSWER_MPS2: f64 = 2.5;
/// Braking that a lead may begin with while the ego's own answer is not enough, m/s². Chosen: a minimum risk manoeuvre
/// (UN R157, 5.5.1).
const LEAD_MAY_BRAKE_MPS2: f64 = 4.0;
/// Time until the braking of a lead is known, s. Found: the objects show hard braking within it (objects/tests.rs).
const NOTICES_S: f64 = 0.25;
/// Scans that must ask for braking, one after the other. Chosen: the errors of one scan alone do not brake.
const CONFIRMS: f64 = 2.0;
/// Distance beyond the margin at which the ego is clear without brakes, m. Chosen: five standard deviations of a range.
const CLEAR_M: f64 = 0.5;
/// A pass that leaves less than this behind it counts as a contact, m. Chosen: as much as the end of a vehicle is
/// uncertain.
const PASS_MARGIN_M: f64 = 1.0;
/// Speed below which the ego or another vehicle stands, m/s. Chosen: half of the resolution of a wheel speed sensor.
const STANDSTILL_MPS: f64 = 0.05;
/// Cost of any contact, and of braking for nothing in excess of it, as closing speeds, m/s. Chosen: a contact at 5 m/s
/// counts twice a touch. Together they give the probabilities 0.65, 0.35 and 0.2 at 0, 12 and 32 m/s.
const CONTACT_COST_MPS: f64 = 5.0;
const FALSE_COST_MPS: f64 = 4.3;
/// Largest share of the expected loss that is left for braking to be worth while. Chosen.
const BETTER_SHARE: f64 = 0.6;
/// Probability from which a contact is as good as certain: to make it milder is reason enough. Chosen.
const CERTAIN: f64 = 0.9;
/// Probability up to which a contact is not to be feared. Chosen.
const REMOTE: f64 = 0.05;
/// Closing speed whose loss is twice that of the lightest contact, m/s. Chosen: contacts count more than their speed.
const SEVERE_MPS: f64 = 60.0;
/// Speed towards the ego from which a vehicle is oncoming, m/s. One that rolls back is slower, and does not turn off.
const ONCOMING_MPS: f64 = 1.0;
/// Share of what braking takes off a closing speed in a time. A delay by this time that loses as much comes too late.
const LOST_SHARE: f64 = 0.25;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub authority: Authority,
    /// Longest time over which lateral motion is carried on, s.
    pub horizon_s: f64,
    pub period_s: f64,
    pub margin_m: f64,
    /// Time by which the warning comes before the braking, where there is time, s.
    pub warning_s: f64,
    pub ego_length_m: f64,
}

/// Request to the brakes, and its reason.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    pub state: BrakeState,
    /// Deceleration, m/s², 0 unless it brakes or holds.
    pub deceleration_mps2: f64,
    /// The threat behind it: gap, m, relative speed, m/s, and lateral offset, m.
    pub threat: Option<(f64, f64, f64)>,
}

#[derive(Clone, Debug)]
pub struct Decision {
    pub settings: Settings,
    state: BrakeState,
    /// The last scan asked for braking.
    asks: bool,
    /// Time in [`BrakeState::Holding`], or without a threat while braking, s.
    waited_s: f64,
}

/// Demand of one object.
#[derive(Clone, Copy, Debug, Default)]
struct Assessment {
    /// Expected loss without brakes.
    loss: f64,
    warns: bool,
    brakes: bool,
}

/// A contact as a plan leads to it.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    probability: f64,
    loss: f64,
}

/// Least probability of a contact to brake for at a closing speed.
fn likely(closing_mps: f64) -> f64 {
    let for_nothing_mps = CONTACT_COST_MPS + FALSE_COST_MPS;
    for_nothing_mps / (for_nothing_mps + CONTACT_COST_MPS + closing_mps.max(0.0))
}

impl Decision {
    pub fn new(settings: Settings) -> Self {
        let state = BrakeState::Monitoring;
        Self { settings, state, asks: false, waited_s: 0.0 }
    }

    /// Takes the objects as they are now, once in each period.
    pub fn step(&mut self, ego: &Ego, objects: impl IntoIterator<Item = Object>) -> Demand {
        let (mut worst, mut all) = (None::<Object>, Assessment::default());
        for object in objects {
            let found = match self.state {
                BrakeState::Braking => self.assess_release(ego, &object),
                _ => self.assess_threat(ego, &object),
            };
            let Some(assessment) = found else { continue };
            all.brakes |= assessment.brakes;
            all.warns |= assessment.warns;
            if worst.is_none() || assessment.loss > all.loss {
                (worst, all.loss) = (Some(object), assessment.loss);
            }
        }
        let waited_s = self.waited_s + self.settings.period_s;
        let before = self.state;
        self.state = match before {
            BrakeState::Braking if ego.speed_mps <= STANDSTILL_MPS => BrakeState::Holding,
            BrakeState::Braking if worst.is_some() || waited_s < UNSEEN_S => BrakeState::Braking,
            BrakeState::Holding if waited_s < HOLD_S => BrakeState::Holding,
            _ if all.brakes && self.asks => BrakeState::Braking,
            _ if all.warns => BrakeState::Warning,
            _ => BrakeState::Monitoring,
        };
        self.asks = all.brakes;
        let waits = worst.is_none() || before == BrakeState::Holding && !all.brakes;
        self.waited_s = if waits && self.state == before { waited_s } else { 0.0 };
        let acts = matches!(self.state, BrakeState::Braking | BrakeState::Holding);
        let full_mps2 = self.settings.authority.deceleration_mps2;
        let reason = worst.filter(|_| self.state != BrakeState::Monitoring);
        Demand {
            state: self.state,
            deceleration_mps2: if acts { full_mps2 } else { 0.0 },
            threat: reason.map(|worst| {
                let relative_mps = worst.speed_mps - ego.speed_mps;
                (worst.distance_m, relative_mps, worst.lateral.position_m)
            }),
        }
    }

    fn threat(&self, object: &Object) -> Threat {
        // The noise of a range rate is not a motion. Over some seconds it would reach an ego that stops closely behind.
        let stands = object.speed_mps.abs() <= STANDSTILL_MPS;
        Threat {
            gap_m: object.distance_m,
            speed_mps: if stands { 0.0 } else { object.speed_mps },
            acceleration_mps2: object.acceleration_mps2,
            passed_m: self.settings.ego_length_m + object.length_m,
        }
    }

    /// It may begin to brake: it moves in the path. What stands cannot, and to come in and to brake at once is rare.
    fn may_brake(&self, object: &Object) -> bool {
        !object.stands() && self.contact(object, Some(Beside::default())).probability > 0.5
    }

    /// Authority that the margin is computed with, before an object that may begin to brake or not.
    fn counted_on(&self, may_brake: bool) -> Authority {
        let authority = self.settings.authority;
        let most_mps2 = if may_brake { COUNTED_ON_MPS2 } else { f64::INFINITY };
        Authority { deceleration_mps2: authority.deceleration_mps2.min(most_mps2), ..authority }
    }

    /// An object while the ego brakes; `None` for what it does not come near to.
    fn assess_release(&self, ego: &Ego, object: &Object) -> Option<Assessment> {
        let Settings { authority, period_s, margin_m, .. } = &self.settings;
        let threat = self.threat(object);
        let steady = Threat { acceleration_mps2: threat.acceleration_mps2.min(0.0), ..threat };
        // It lets go of its brakes, which then are off at once.
        let unbraked = Ego { acceleration_mps2: ego.acceleration_mps2.max(0.0), ..*ego };
        let released = authority.beside(&unbraked, &steady, NEVER_S, *margin_m + CLEAR_M);
        let near = self.contact(object, released);
        let counted_on = self.counted_on(self.may_brake(object));
        let again = counted_on.beside(&unbraked, &steady, *period_s, *margin_m);
        let probability = near.probability.max(self.contact(object, again).probability);
        (probability > REMOTE).then(|| Assessment { loss: near.loss, ..Assessment::default() })
    }

    /// An object while the ego does not brake; `None` for what it does not come near to.
    fn assess_threat(&self, ego: &Ego, object: &Object) -> Option<Assessment> {
        let Settings { authority, period_s, margin_m, warning_s, .. } = &self.settings;
        let threat = self.threat(object);
        let passing = Threat { passed_m: threat.passed_m + PASS_MARGIN_M, ..threat };
        let keep = authority.beside(ego, &passing, NEVER_S, 0.0)?;
        let kept = self.contact(object, Some(keep));
        let mut assessment = Assessment { loss: kept.loss, ..Assessment::default() };
        // An object that was not seen lately may be gone: two echoes that were one are two again.
        if !object.is_seen || kept.probability < likely(ego.speed_mps - object.speed_mps) {
            return (kept.probability > REMOTE).then_some(assessment);
        }
        let is_late = |authority: &Authority, threat: &Threat, wait_s: f64| {
            let beside = authority.beside(ego, threat, wait_s, *margin_m);
            self.contact(object, beside).probability > REMOTE
        };
        let may_brake = self.may_brake(object);
        let counted_on = self.counted_on(may_brake);
        let brakes_too = if may_brake { self.brakes_too(ego, object, &threat) } else { None };
        let late = |wait_s: f64| match threat.speed_mps < -ONCOMING_MPS {
            true => is_harder(ego, &counted_on, &threat, wait_s),
            false => {
                is_late(&counted_on, &threat, wait_s)
                    || brakes_too.is_some_and(|lead| is_late(authority, &lead, wait_s + NOTICES_S))
            }
        };
        let share = if kept.probability > CERTAIN { 1.0 } else { BETTER_SHARE };
        let braked = || authority.beside(ego, &threat, 0.0, 0.0);
        assessment.brakes =
            late(CONFIRMS * *period_s) && self.contact(object, braked()).loss < share * kept.loss;
        assessment.warns = assessment.brakes || late(*period_s + *warning_s);
        Some(assessment)
    }

    /// A lead as it may begin to brake. `None` where braking as of a driver is enough: then there is time for an answer.
    fn brakes_too(&self, ego: &Ego, object: &Object, lead: &Threat) -> Option<Threat> {
        let answer = Authority { deceleration_mps2: ANSWER_MPS2, ..self.settings.authority };
        let touched = answer.beside(ego, lead, 0.0, 0.0);
        let acceleration_mps2 = lead.acceleration_mps2.min(-LEAD_MAY_BRAKE_MPS2);
        (self.contact(object, touched).probability > REMOTE)
            .then_some(Threat { acceleration_mps2, ..*lead })
    }

    /// Contact with `object` in the time in which the ego is beside it.
    fn contact(&self, object: &Object, beside: Option<Beside>) -> Contact {
        let mut contact = Contact::default();
        let Some(beside) = beside else { return contact };
        for h in &object.lateral.states {
            let inward_mps = -h.rate_mps * h.position_m.signum();
            let offset_m = h.position_m.abs();
            // An object that comes in stays; one that leaves is nearest at once.
            let time_s = if inward_mps > 0.0 { beside.last_s } else { beside.first_s };
            let time_s = time_s.min(self.settings.horizon_s);
            let sigma_m = libm::hypot(h.sigma_after_m(time_s), object.way_sigma_m);
            let touches = overlap(WIDTH_M, (offset_m - inward_mps * time_s).max(0.0), sigma_m);
            let probability = object.probability * h.probability * touches;
            contact.probability += probability;
            contact.loss += probability * (1.0 + beside.first_mps.abs() / SEVERE_MPS);
        }
        contact
    }
}

/// True if an oncoming vehicle is met at a higher speed when braking begins later. However early the ego stands, it may
/// be reached. Until it could no longer stand by then, to wait shows whether the vehicle turns off.
fn is_harder(ego: &Ego, authority: &Authority, threat: &Threat, wait_s: f64) -> bool {
    let closing_mps = |wait_s| {
        let beside = authority.beside(ego, threat, wait_s, 0.0);
        // The ego stands by then.
        beside.map_or(-threat.speed_mps, |beside| beside.first_mps)
    };
    let gained_mps = authority.deceleration_mps2 * wait_s;
    closing_mps(wait_s) - closing_mps(0.0) > LOST_SHARE * gained_mps
}

#[cfg(test)]
mod tests;
