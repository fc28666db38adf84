//! When to warn, when to brake, when to let go.
//!
//! The ego is beside an object along the road for a time that depends on what it does ([`Plan`]). They touch if the
//! object is in the ego's path in that time. The probability of this is a sum over the lateral speeds that the object
//! may have ([`crate::filter`]). To brake shortens the time, or makes it longer where the ego would have passed: the
//! same sums decide both.
//!
//! | state | entered | left |
//! |---|---|---|
//! | [`BrakeState::Monitoring`] | at the start | |
//! | [`BrakeState::Warning`] | as braking, with braking that begins `warning_s` later | no such threat |
//! | [`BrakeState::Braking`] | a contact is likely, braking makes it less likely or milder, and one cycle later it may leave less than the margin | letting go is safe, or surely passes; the ego stands |
//! | [`BrakeState::Holding`] | the ego stands after braking | after `hold_s` |
//!
//! The margin is computed with less than the brakes' authority (`counted_on_mps2` of [`Numbers`]). The rest is the
//! reserve for another vehicle that begins to brake. A lead, which moves in the path, may do so with
//! `lead_may_brake_mps2`. A driver's braking (`answer_mps2`) may no longer be enough. The whole authority must then
//! still leave the margin when that is noticed (`notices_s`).
//!
//! Letting go is safe if two things hold. Without brakes the ego comes no nearer than the margin and `clear_m`. And if
//! the other vehicle brakes on, as hard as it did during the intervention, braking anew leaves the margin.
//!
//! An oncoming vehicle may reach the ego however early it stands. Braking for it begins when the contact would otherwise
//! be harder.
//!
//! An object on a row that crosses the ego's way may stand beside a curve ahead. It neither warns nor brakes before the
//! last point to steer (`steer_s`): the road would have bent by then.
//!
//! A contact is likely if it is with the ego's present acceleration. Cruise control and driver brake long
//! before the last point, so that their braking keeps this system silent. Source of the order of warning and
//! braking: UN R152, paragraphs 5.2.1 and 6.4.

use crate::filter::overlap;
use crate::numbers::Numbers;
use crate::object::Object;
use crate::prediction::{Authority, Beside, Ego, Plan, Threat};
use crate::row::Places;
use messages::BrakeState;

/// Speed towards the ego from which a vehicle is oncoming, m/s. One that rolls back is slower, and does not turn off.
const ONCOMING_MPS: f64 = 1.0;
/// Share of what braking takes off a closing speed in a time. A delay by this time that loses as much comes too late.
const LOST_SHARE: f64 = 0.25;

/// The ego's swept path, and the time ahead for which lateral motion is extrapolated.
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
    /// Capability of the brakes.
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

/// Request to the brakes, and its reason.
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
    numbers: Numbers,
    state: BrakeState,
    /// Time in [`BrakeState::Holding`], or without a threat while braking, s.
    waited_s: f64,
    /// Hardest acceleration of a threat in this intervention, m/s², at most 0.
    hardest_mps2: f64,
}

/// Demand of one object.
#[derive(Clone, Copy, Debug)]
struct Assessment {
    /// Expected loss without brakes.
    loss: f64,
    warns: bool,
    brakes: bool,
    /// The ego is clear of it without brakes.
    clear: bool,
    acceleration_mps2: f64,
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
        Self::with_numbers(settings, Numbers::DEFAULT)
    }

    /// The same with other numbers.
    #[must_use]
    pub fn with_numbers(settings: Settings, numbers: Numbers) -> Self {
        let state = BrakeState::Monitoring;
        Self { settings, numbers, state, waited_s: 0.0, hardest_mps2: 0.0 }
    }

    /// The state after the last step.
    #[must_use]
    pub fn state(&self) -> BrakeState {
        self.state
    }

    /// The ego's swept path.
    #[must_use]
    pub fn path(&self) -> Path {
        self.settings.path
    }

    /// Takes the objects as they are now among standing `places`, once in each period.
    pub fn step(
        &mut self,
        ego: &Ego,
        objects: impl IntoIterator<Item = Object>,
        places: &Places,
    ) -> Demand {
        let assess = |object: Object| self.assess(ego, &object, places);
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
        let Numbers { standstill_mps, unseen_s, hold_s, .. } = self.numbers;
        let waited_s = self.waited_s + self.settings.period_s;
        let before = self.state;
        self.state = match before {
            BrakeState::Braking if ego.speed_mps <= standstill_mps => BrakeState::Holding,
            BrakeState::Braking if worst.is_none() && waited_s < unseen_s => BrakeState::Braking,
            BrakeState::Braking if worst.is_some() && !clear => BrakeState::Braking,
            BrakeState::Holding if waited_s < hold_s => BrakeState::Holding,
            _ if brakes => BrakeState::Braking,
            _ if warns => BrakeState::Warning,
            _ => BrakeState::Monitoring,
        };
        let waits =
            self.state == before && !brakes && worst.is_none_or(|_| before == BrakeState::Holding);
        self.waited_s = if waits { waited_s } else { 0.0 };
        let of_worst = worst.map_or(0.0, |worst| worst.acceleration_mps2.min(0.0));
        self.hardest_mps2 = match self.state {
            BrakeState::Braking => self.hardest_mps2.min(of_worst),
            _ => 0.0,
        };
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
    fn assess(&self, ego: &Ego, object: &Object, places: &Places) -> Option<Assessment> {
        let Settings { authority, period_s, margin_m, warning_s, ego_length_m, .. } =
            &self.settings;
        // The noise of a range rate is not a motion. Over some seconds it would reach an ego that stops closely behind.
        let stands = object.speed_mps.abs() <= self.numbers.standstill_mps;
        let threat = Threat {
            gap_m: object.distance_m,
            speed_mps: if stands { 0.0 } else { object.speed_mps },
            acceleration_mps2: object.acceleration_mps2,
            passed_m: ego_length_m + object.length_m,
        };
        let steady = Threat { acceleration_mps2: object.acceleration_mps2.min(0.0), ..threat };
        let numbers = &self.numbers;
        // A standing object cannot begin to brake: no reserve is kept for it.
        let counted_on = Authority {
            deceleration_mps2: if object.stands() {
                authority.deceleration_mps2
            } else {
                authority.deceleration_mps2.min(numbers.counted_on_mps2)
            },
            ..*authority
        };
        let contact = |threat: &Threat, plan: Plan, clear_m: f64| {
            let beside = authority.beside(ego, threat, plan, clear_m);
            beside.map_or(Contact::default(), |beside| self.contact(object, &beside))
        };
        let mut assessment = Assessment {
            loss: 0.0,
            warns: false,
            brakes: false,
            clear: true,
            acceleration_mps2: object.acceleration_mps2,
            threat: (
                object.distance_m,
                object.speed_mps - ego.speed_mps,
                object.lateral.position_m,
            ),
        };
        if self.state == BrakeState::Braking {
            let near = contact(&steady, Plan::Release, *margin_m + numbers.clear_m);
            let brakes_on = Threat {
                acceleration_mps2: steady.acceleration_mps2.min(self.hardest_mps2),
                ..threat
            };
            let released = Ego { acceleration_mps2: ego.acceleration_mps2.max(0.0), ..*ego };
            let anew = |threat: &Threat| {
                let beside =
                    counted_on.beside(&released, threat, Plan::Brake(*period_s), *margin_m);
                beside.map_or(0.0, |beside| self.contact(object, &beside).probability)
            };
            let passes = || {
                let release = contact(&steady, Plan::Release, 0.0);
                release.probability <= numbers.clear_probability
                    && release.loss < contact(&threat, Plan::BrakeOn, 0.0).loss
            };
            assessment.loss = near.loss;
            let is_safe = near.probability <= numbers.clear_probability
                && anew(&brakes_on) <= numbers.clear_probability;
            assessment.clear = is_safe || passes();
            let matters = near.probability.max(anew(&brakes_on)) > numbers.of_no_interest;
            return matters.then_some(assessment);
        }
        let passing = Threat { passed_m: threat.passed_m + numbers.pass_margin_m, ..threat };
        let kept = contact(&passing, Plan::Keep, 0.0);
        assessment.loss = kept.loss;
        if kept.probability < numbers.likely(ego.speed_mps - object.speed_mps) {
            return (kept.probability > numbers.of_no_interest).then_some(assessment);
        }
        if object.row_m.is_some()
            && !self.is_last_point_to_steer(ego, &passing)
            && places.have_on_row(object)
        {
            return Some(assessment);
        }
        // Each prediction is made only where those before it leave the question open.
        let is_late = |authority: &Authority, threat: &Threat, wait_s: f64| {
            let beside = authority.beside(ego, threat, Plan::Brake(wait_s), *margin_m);
            beside.is_some_and(|beside| self.contact(object, &beside).probability > numbers.remote)
        };
        let brakes_too = self.brakes_too(ego, object, &threat);
        let late = |wait_s: f64| match threat.speed_mps < -ONCOMING_MPS {
            true => Self::is_harder(ego, &counted_on, &threat, wait_s),
            false => {
                is_late(&counted_on, &threat, wait_s)
                    || (brakes_too.as_ref())
                        .is_some_and(|lead| is_late(authority, lead, wait_s + numbers.notices_s))
            }
        };
        let share = if kept.probability > numbers.certain { 1.0 } else { numbers.better_share };
        assessment.brakes =
            late(*period_s) && contact(&threat, Plan::Brake(0.0), 0.0).loss < share * kept.loss;
        assessment.warns = assessment.brakes || late(*period_s + *warning_s);
        Some(assessment)
    }

    /// True if an oncoming vehicle is met at a higher speed when braking begins later. However early the ego stands, it
    /// may be reached. Until it could no longer stand by then, to wait shows whether the vehicle turns off.
    fn is_harder(ego: &Ego, authority: &Authority, threat: &Threat, wait_s: f64) -> bool {
        let closing_mps = |wait_s| {
            let beside = authority.beside(ego, threat, Plan::Brake(wait_s), 0.0);
            // The ego stands by then.
            beside.map_or(-threat.speed_mps, |beside| beside.first_mps)
        };
        let gained_mps = authority.deceleration_mps2 * wait_s;
        closing_mps(wait_s) - closing_mps(0.0) > LOST_SHARE * gained_mps
    }

    /// True if what is ahead is reached so soon that the ego would have to steer now to miss it.
    fn is_last_point_to_steer(&self, ego: &Ego, threat: &Threat) -> bool {
        let beside = self.settings.authority.beside(ego, threat, Plan::Keep, 0.0);
        beside.is_some_and(|beside| beside.first_s <= self.numbers.steer_s)
    }

    /// True if it is probably in the ego's path already.
    fn is_in_path(&self, object: &Object) -> bool {
        let reach_m = self.settings.path.half_width_m + object.half_width_m;
        let overlaps = object.lateral.hypotheses().map(|h| {
            let sigma_m = libm::hypot(h.sigma_m, object.way_sigma_m);
            h.probability * overlap(reach_m, h.position_m.abs(), sigma_m)
        });
        overlaps.sum::<f64>() > 0.5
    }

    /// A lead as it may begin to brake. `None` of what is not in the path yet: to come in and to brake at once is rare.
    /// `None` also where braking as of a driver is enough: then there is time for an answer.
    fn brakes_too(&self, ego: &Ego, object: &Object, lead: &Threat) -> Option<Threat> {
        if object.stands() || !self.is_in_path(object) {
            return None;
        }
        let Numbers { answer_mps2, lead_may_brake_mps2, remote, .. } = self.numbers;
        let answer = Authority { deceleration_mps2: answer_mps2, ..self.settings.authority };
        let touched = answer.beside(ego, lead, Plan::Brake(0.0), 0.0)?;
        let acceleration_mps2 = lead.acceleration_mps2.min(-lead_may_brake_mps2);
        (self.contact(object, &touched).probability > remote)
            .then_some(Threat { acceleration_mps2, ..*lead })
    }

    /// Probability of a contact with `object` in the time in which the ego is beside it.
    fn contact(&self, object: &Object, beside: &Beside) -> Contact {
        let Path { half_width_m, horizon_s, .. } = self.settings.path;
        let reach_m = half_width_m + object.half_width_m;
        let numbers = &self.numbers;
        let mut contact = Contact::default();
        for h in object.lateral.hypotheses() {
            let side = h.position_m.signum();
            let inward_mps = -h.rate_mps * side;
            let offset_m = h.position_m.abs();
            // An object that comes in stays; one that leaves is nearest at once.
            let time_s =
                if inward_mps > 0.0 { beside.last_s.min(horizon_s) } else { beside.first_s };
            let moved_m = inward_mps * time_s;
            let then_m = match inward_mps > 0.0 {
                true => (offset_m - moved_m).max(0.0),
                false if offset_m > numbers.leaving_offset_m => offset_m - moved_m,
                false => offset_m,
            };
            let sigma_m = libm::hypot(h.sigma_after_m(time_s.min(horizon_s)), object.way_sigma_m);
            let touches = overlap(reach_m, then_m, sigma_m);
            let in_s = if inward_mps > 0.0 { (offset_m - reach_m) / inward_mps } else { 0.0 };
            let wanders = (1.0 - h.rate_mps.abs() / numbers.wandering_mps).max(0.0);
            let goes_on = libm::exp(-numbers.ceases_per_s * wanders * in_s.max(0.0));
            let probability = object.probability * h.probability * touches * goes_on;
            let closing_mps = beside.closing_mps(in_s);
            contact.probability += probability;
            contact.loss += probability * (1.0 + closing_mps.abs() / numbers.severe_mps);
        }
        contact
    }
}

#[cfg(test)]
mod tests;
