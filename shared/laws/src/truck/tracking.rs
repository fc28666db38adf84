//! The plan in hand: where the truck is in it, when it must be made anew, when it is stale, and whether its map is
//! trusted.
//!
//! The torque of the first segment is held to its end. A new plan is asked for there, at a gear change, when the set speed
//! changes, and when the speed is too far off. Until it arrives, the plan in hand goes on, into its later segments if
//! need be. Beyond its end, or far off it, there is no plan.

use law::{Input, Plan, PlanRequest, Powertrain, Preview, Segment};

/// Deviation from the plan's speed that asks for a new plan, m/s. Inferred; half and double changed no figure.
const REPLAN_MPS: f64 = 0.6;
/// Deviation at which a plan is stale, m/s.
const STALE_MPS: f64 = 2.5;
/// Oldest plan that is followed, s.
const STALE_S: f64 = 90.0;
/// A request without answer is repeated after this, s; so is one that had no plan as its answer.
const REPEAT_S: f64 = 1.0;
/// Time before a segment's end at which its successor is asked for, s: it must be there in time.
const AHEAD_S: f64 = 0.3;

/// The plan in hand and the question that is out.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracking {
    pub(crate) plan: Plan,
    /// Conditions for which the plan was made.
    gear: usize,
    limits_mps: (f64, f64),
    number: u64,
    asked_s: Option<f64>,
    answered: u64,
}

/// The plan at the truck's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Guidance {
    pub(crate) segment: Segment,
    /// Planned speed here, m/s.
    pub(crate) speed_mps: f64,
    pub(crate) index: usize,
}

impl Tracking {
    /// Takes a plan, unless a newer one is in hand. An empty one means "no plan".
    pub(crate) fn accept(&mut self, plan: &Plan) {
        if plan.number <= self.answered || plan.number > self.number {
            return;
        }
        self.answered = plan.number;
        if plan.len > 0 {
            self.plan = *plan;
            self.asked_s = None;
        }
    }

    /// The plan at present; `None` when there is none or it is stale.
    pub(crate) fn guidance(&self, input: &Input) -> Option<Guidance> {
        let position_m = input.ego.position_m;
        let index = self.plan.segment_at(position_m)?;
        let speed_mps = self.plan.speed_mps(index, position_m);
        let age_s = input.time_s - self.plan.time_s;
        let stale =
            (speed_mps - input.ego.speed_mps).abs() > STALE_MPS || !(0.0..STALE_S).contains(&age_s);
        (!stale).then_some(Guidance { segment: self.plan.segments[index], speed_mps, index })
    }

    /// Requests a new plan at a price of time, if the plan in hand does not hold.
    pub(crate) fn request(
        &mut self,
        input: &Input,
        powertrain: &Powertrain,
        preview: &Preview,
        time_price: f64,
        guidance: Option<&Guidance>,
    ) -> Option<PlanRequest> {
        if self.asked_s.is_some_and(|asked_s| (0.0..REPEAT_S).contains(&(input.time_s - asked_s))) {
            return None;
        }
        let limits_mps = (input.set_speed_mps, input.speed_limit_mps);
        let soon_m = input.ego.position_m + AHEAD_S * input.ego.speed_mps;
        let holds = guidance.is_some_and(|guidance| {
            guidance.index < self.plan.binding
                && self.plan.segments[self.plan.binding - 1].end_m > soon_m
                && (guidance.speed_mps - input.ego.speed_mps).abs() <= REPLAN_MPS
                && self.gear == powertrain.gear
                && self.limits_mps == limits_mps
        });
        if holds {
            return None;
        }
        self.gear = powertrain.gear;
        self.limits_mps = limits_mps;
        self.number += 1;
        self.asked_s = Some(input.time_s);
        Some(PlanRequest {
            number: self.number,
            time_s: input.time_s,
            position_m: input.ego.position_m,
            speed_mps: input.ego.speed_mps,
            gear: powertrain.gear,
            engine_torque_nm: powertrain.engine_torque_nm,
            set_speed_mps: input.set_speed_mps,
            speed_limit_mps: input.speed_limit_mps,
            time_price,
            preview: *preview,
        })
    }
}

/// Time constant of the average, s.
const AVERAGING_S: f64 = 10.0;
/// The mean difference at which the map is given up, and at which it is used again.
const LIMITS: (f64, f64) = (0.012, 0.006);

/// Whether the map describes the road that the truck feels.
///
/// The difference between the map's grade under the truck and the vehicle's own estimate is averaged over some seconds.
/// Noise and a map shifted by some tens of metres stay far below the limit; another road does not.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapTrust {
    difference: f64,
    /// True if the map contradicts the vehicle.
    pub lost: bool,
}

impl MapTrust {
    /// Compares the map's grade with the felt one over `dt_s`; does nothing without a map.
    pub fn update(&mut self, map: Option<f64>, own: f64, dt_s: f64) {
        let Some(map) = map else { return };
        let share = 1.0 - libm::exp(-dt_s / AVERAGING_S);
        self.difference += share * (map - own - self.difference);
        let limit = if self.lost { LIMITS.1 } else { LIMITS.0 };
        self.lost = self.difference.abs() > limit;
    }
}
