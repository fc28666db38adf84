//! The judge of a drive: rectangles, and brakes that could have been.
//!
//! The oracle uses the motion of all vehicles ([`crate::scene`]) and of the ego. It uses nothing of radar, laws and
//! emergency brake. It moves bodies by code of its own. Otherwise a fault of the plant's contact or of its required
//! deceleration would judge itself. The driver's numbers alone are shared ([`supervise::ReferenceDriver`]).
//!
//! | question | answer |
//! |---|---|
//! | contact | the rectangles of the ego and of another vehicle overlap |
//! | need | the first time at which 2.5 m/s² from now on would not avoid a vehicle in the ego's path that goes on as it does |
//! | avoidable | a reference that takes over 0.35 s after the need, and brakes to standstill, has no contact |
//! | needless | from the start of an intervention on 1.5 m/s² to standstill has no contact |
//!
//! The reference brakes with 6 m/s² at once where the emergency brake is on. Without it, it has the law's hardest
//! request and the actuator's lag. In both the other vehicles move as they really did, also after the drive's end.
//!
//! Chosen: 1.5 m/s², braking that passengers hardly notice.

use supervise::DriveStep;

use crate::limits::{GENTLE_MPS2, NEED_MPS2, REACTION_S, REFERENCE_MPS2};
use crate::scene::{Actor, CAR_LENGTH_M, Place};

/// Step of the oracle's motions, s.
const STEP_S: f64 = 0.01;
/// Steps of a drive between two looks for the need.
const LOOK_STEPS: usize = 5;

/// Brakes that could have been.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brakes {
    pub deceleration_mps2: f64,
    /// Lag of the deceleration behind the request, s.
    pub lag_s: f64,
}

impl Brakes {
    /// The reference beside an emergency brake.
    pub const EMERGENCY: Self = Self { deceleration_mps2: REFERENCE_MPS2, lag_s: 0.0 };
    const GENTLE: Self = Self { deceleration_mps2: GENTLE_MPS2, lag_s: 0.0 };

    /// Acceleration after another step of braking, m/s².
    fn after(&self, acceleration_mps2: f64) -> f64 {
        let kept = if self.lag_s > 0.0 { libm::exp(-STEP_S / self.lag_s) } else { 0.0 };
        -self.deceleration_mps2 + (acceleration_mps2 + self.deceleration_mps2) * kept
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Ego {
    time_s: f64,
    front_m: f64,
    speed_mps: f64,
    acceleration_mps2: f64,
}

impl Ego {
    fn of(step: &DriveStep) -> Self {
        Self {
            time_s: step.time_s,
            front_m: step.position_m,
            speed_mps: step.speed_mps,
            acceleration_mps2: step.acceleration_mps2,
        }
    }

    /// One step later with a constant acceleration; it stops rather than reverse.
    fn advance(&mut self, acceleration_mps2: f64) {
        let next_mps = (self.speed_mps + acceleration_mps2 * STEP_S).max(0.0);
        self.front_m += 0.5 * STEP_S * (self.speed_mps + next_mps);
        self.speed_mps = next_mps;
        self.acceleration_mps2 = acceleration_mps2;
        self.time_s += STEP_S;
    }

    fn touches(&self, actor: &Actor, place: &Place) -> bool {
        let gap_m = place.rear_m - self.front_m;
        actor.is_in_path(place) && gap_m < 0.0 && gap_m > -(actor.length_m + CAR_LENGTH_M)
    }
}

/// The drive of an ego among vehicles with a known motion.
#[derive(Clone, Copy, Debug)]
pub struct Oracle<'a> {
    actors: &'a [Actor],
    steps: &'a [DriveStep],
}

impl<'a> Oracle<'a> {
    /// The oracle of a drive among `actors`.
    pub fn new(actors: &'a [Actor], steps: &'a [DriveStep]) -> Self {
        Self { actors, steps }
    }

    /// The drive has a contact, or ends within a step of one.
    pub fn has_contact(&self) -> bool {
        let last = self.steps.last().map(|last| {
            let mut after = Ego::of(last);
            after.advance(last.acceleration_mps2);
            after
        });
        self.steps.iter().map(Ego::of).chain(last).any(|ego| self.is_contact(&ego))
    }

    /// The contact of the drive could have been avoided by these brakes, 0.35 s after they were needed.
    pub fn is_avoidable(&self, brakes: &Brakes) -> bool {
        let looks = self.steps.iter().step_by(LOOK_STEPS).map(Ego::of);
        let Some(need) = looks.into_iter().find(|ego| self.is_needed(ego)) else { return false };
        let takes_over_s = need.time_s + REACTION_S;
        let from = self.steps.iter().find(|step| step.time_s >= takes_over_s);
        from.is_some_and(|from| !self.hits(Ego::of(from), brakes))
    }

    /// An intervention that began at `time_s` was not needed.
    pub fn is_needless(&self, time_s: f64) -> bool {
        let from = self.steps.iter().find(|step| step.time_s >= time_s - 1e-9);
        from.is_some_and(|from| !self.hits(Ego::of(from), &Brakes::GENTLE))
    }

    fn is_contact(&self, ego: &Ego) -> bool {
        self.actors.iter().any(|actor| ego.touches(actor, &actor.at(ego.time_s)))
    }

    /// Braking to standstill from `ego` on has a contact.
    fn hits(&self, mut ego: Ego, brakes: &Brakes) -> bool {
        while ego.speed_mps > 0.0 {
            ego.advance(brakes.after(ego.acceleration_mps2));
            if self.is_contact(&ego) {
                return true;
            }
        }
        false
    }

    /// [`NEED_MPS2`] from now on does not avoid a vehicle that is in the path now and keeps its motion.
    fn is_needed(&self, ego: &Ego) -> bool {
        self.actors.iter().any(|actor| {
            let place = actor.at(ego.time_s);
            let is_ahead = place.rear_m + actor.length_m > ego.front_m;
            if !is_ahead || !actor.is_in_path(&place) {
                return false;
            }
            let (mut own, mut rear_m, mut speed_mps) = (*ego, place.rear_m, place.speed_mps);
            while own.speed_mps > 0.0 {
                own.advance(-NEED_MPS2);
                let next_mps = (speed_mps + place.acceleration_mps2 * STEP_S).max(0.0);
                rear_m += 0.5 * STEP_S * (speed_mps + next_mps);
                speed_mps = next_mps;
                if rear_m < own.front_m {
                    return true;
                }
            }
            false
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LateralChange, SpeedChange};

    /// An ego that keeps 20 m/s for `duration_s`.
    fn steady(duration_s: f64) -> Vec<DriveStep> {
        let step = |k: u32| {
            let time_s = f64::from(k) * STEP_S;
            DriveStep { time_s, position_m: 20.0 * time_s, speed_mps: 20.0, ..DriveStep::default() }
        };
        (0..(duration_s / STEP_S) as u32).map(step).collect()
    }

    #[test]
    fn bodies_that_are_apart_in_one_direction_do_not_touch() {
        let steps = steady(5.0);
        let touches = |actor: Actor| Oracle::new(&[actor], &steps).has_contact();
        assert!(touches(Actor::car("car", 30.0, 0.0)));
        assert!(!touches(Actor { lateral_m: 1.85, ..Actor::car("beside", 30.0, 0.0) }));
        assert!(touches(Actor { lateral_m: 1.75, ..Actor::car("near", 30.0, 0.0) }));
        let rider = Actor { width_m: 0.6, lateral_m: 1.25, ..Actor::car("rider", 30.0, 0.0) };
        assert!(!touches(rider));
        assert!(!touches(Actor::car("far", 101.0, 0.0)));
    }

    /// 20 m/s: the need is 80 m before what stands. 7 m of reaction and 33.3 m of braking are enough.
    #[test]
    fn a_vehicle_that_stands_in_sight_is_avoidable() {
        let (steps, car) = (steady(10.0), [Actor::car("car", 120.0, 0.0)]);
        assert!(Oracle::new(&car, &steps).is_avoidable(&Brakes::EMERGENCY));
        let weak = Brakes { deceleration_mps2: 2.6, lag_s: 0.5 };
        assert!(!Oracle::new(&car, &steps).is_avoidable(&weak), "7 m less are left");
    }

    /// It comes in 25 m ahead and stands: 7 m and 33.3 m are too far.
    #[test]
    fn a_vehicle_that_comes_in_at_the_last_moment_is_not() {
        let at = |gap_m: f64| Actor {
            lateral_m: 3.0,
            laterals: vec![LateralChange { from_s: 2.0, to_m: 0.0, lasts_s: 0.1 }],
            ..Actor::car("car", 40.0 + gap_m, 0.0)
        };
        let steps = steady(10.0);
        let avoidable = |gap_m| Oracle::new(&[at(gap_m)], &steps).is_avoidable(&Brakes::EMERGENCY);
        assert!(!avoidable(25.0) && !avoidable(40.0) && avoidable(46.0));
    }

    #[test]
    fn a_lead_that_brakes_gently_needs_no_intervention() {
        let braking = |rate_mps2: f64, gap_m: f64| Actor {
            speeds: vec![SpeedChange { from_s: 1.0, to_mps: 0.0, rate_mps2 }],
            ..Actor::car("lead", gap_m, 20.0)
        };
        let steps = steady(12.0);
        let needless = |actor: Actor| Oracle::new(&[actor], &steps).is_needless(2.0);
        assert!(needless(braking(1.5, 40.0)));
        assert!(!needless(braking(6.0, 40.0)), "33 m against 133 m");
        assert!(needless(Actor { lateral_m: 3.5, ..Actor::car("beside", 60.0, 0.0) }));
    }
}
