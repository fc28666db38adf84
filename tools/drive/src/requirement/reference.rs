//! `no-avoidable-collision`: no collision, unless a reference driver could not avoid it either.
//!
//! ```text
//! ego approaches the vehicle     need           reference brakes            stands
//! ──┼──────────────────────────────┼───── 0.35 s ─────┼───────── 6 m/s² ───────┼──
//! ```
//!
//! The reference takes the ego's place at the need. That is the first instant of the encounter at which the ego needs
//! more deceleration than the plant's stop in lane. It keeps its speed for the reaction time, and then brakes evenly to
//! a stand. The other vehicles move as they did ([`Others`]). The encounter is the time for which the ego has been at
//! least as fast as the vehicle, without a break. An encounter without a need counts from its beginning.
//!
//! The margin is that of "the reference has no contact, implies no collision". It is the larger one of `no-collision`'s
//! margin and minus the reference's. Both of its units have a tolerance of one half, so that their numbers compare.
//!
//! The driver is [`ReferenceDriver::REGULATION`]. Brakes that give less than 6 m/s², as a truck's, limit it too.

use super::contact::{Closest, ReferenceDriver, finding};
use super::evidence::{Evidence, Finding};
use super::others::Others;
use crate::DriveStep;
use plant::ahead::{Ahead, required_deceleration};
use temporal_logic::Unit;

/// Step of the reference's motion, s.
const STEP_S: f64 = 0.01;

/// True if the drive ended in a collision that the reference driver avoids.
pub fn is_avoidable_collision(evidence: &Evidence<'_>) -> bool {
    !no_avoidable_collision(evidence).met
}

pub(super) fn no_avoidable_collision(evidence: &Evidence<'_>) -> Finding {
    let others = Others::of(evidence);
    let closest = Closest::of(evidence, &others);
    let driven = finding(evidence, closest.as_ref());
    let Some(closest) = closest else { return driven };
    let ego = &evidence.drive.steps[closest.step];
    // Braking does not help against a vehicle that comes from behind.
    let is_from_behind = !driven.met && !others.is_ahead(&closest.other, ego.position_m);
    let (from, reference) = if is_from_behind {
        (ego, Margin { value: driven.value, unit: driven.unit })
    } else {
        let need = need(evidence, &others, &closest);
        (need, margin(driver(evidence), need, &others))
    };
    let met = driven.met || reference.value <= 0.0;
    if -reference.value > driven.value {
        Finding { value: -reference.value, unit: reference.unit, time_s: from.time_s, met }
    } else {
        Finding { met, ..driven }
    }
}

/// The step from which the reference reacts.
fn need<'a>(evidence: &Evidence<'a>, others: &Others<'_>, closest: &Closest) -> &'a DriveStep {
    let steps = &evidence.drive.steps;
    let partner = |ego: &DriveStep| {
        let near = others.nearest(ego.position_m, ego.time_s)?;
        (near.identity == closest.other.identity).then_some(near)
    };
    let approaches = |ego: &DriveStep| partner(ego).is_some_and(|o| ego.speed_mps >= o.speed_mps);
    let before = steps[..closest.step].iter().rev().take_while(|ego| approaches(ego)).count();
    let encounter = &steps[closest.step - before..=closest.step];
    let comfortable_mps2 = evidence.scenario.plant.fallback.stop_deceleration_mps2.value();
    let needs = |ego: &&DriveStep| {
        partner(ego).is_some_and(|other| {
            let ahead = Ahead {
                gap_m: other.rear_m - ego.position_m,
                speed_mps: other.speed_mps,
                acceleration_mps2: other.acceleration_mps2,
            };
            required_deceleration(ego.speed_mps, &ahead) > comfortable_mps2
        })
    };
    encounter.iter().find(needs).unwrap_or(&encounter[0])
}

/// The least gap of the reference, or minus its impact speed.
struct Margin {
    value: f64,
    unit: Unit,
}

/// The reference driver with the ego's brakes.
fn driver(evidence: &Evidence<'_>) -> ReferenceDriver {
    let brakes_mps2 = evidence.scenario.aebs.deceleration_mps2.value();
    ReferenceDriver::REGULATION.with_brakes(brakes_mps2)
}

fn margin(driver: ReferenceDriver, need: &DriveStep, others: &Others<'_>) -> Margin {
    let ReferenceDriver { reaction_s, deceleration_mps2: a, .. } = driver;
    let v = need.speed_mps;
    let brakes_s = v / a;
    let stop_s = reaction_s + brakes_s;
    let mut least_m = f64::INFINITY;
    for step in 0..=(stop_s / STEP_S).ceil() as u64 {
        let since_s = step as f64 * STEP_S;
        let braked_s = (since_s - reaction_s).clamp(0.0, brakes_s);
        let front_m = need.position_m + v * since_s.min(stop_s) - 0.5 * a * braked_s * braked_s;
        let speed_mps = v - a * braked_s;
        let ahead = others.in_lane_at(need.time_s + since_s);
        for other in ahead.filter(|other| others.is_ahead(other, front_m)) {
            let gap_m = other.rear_m - front_m;
            if gap_m <= 0.0 {
                let impact_mps = (speed_mps - other.speed_mps).abs();
                return Margin { value: -impact_mps, unit: Unit::METRE_PER_SECOND };
            }
            least_m = least_m.min(gap_m);
        }
    }
    Margin { value: least_m, unit: Unit::METRE }
}
