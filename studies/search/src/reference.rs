//! The reference driver. A scene that it cannot avoid holds no failure of the law.
//!
//! ```text
//! follows:  a = a0 (1 − (v/v0)⁴ − (s*/s)²),   s* = s0 + v T + v Δv / (2 √(a0 b))      within [−2.5 m/s², a0]
//! needs:    more than 2.5 m/s² to stay behind what is in its path and goes on as it does
//! brakes:   `reaction_s` after the need, with `deceleration_mps2`, until the need is over
//! ```
//!
//! It uses the true traffic, and nothing of radar, faults and delays. Its drive needs no services: the traffic of the
//! scenario moves, and the driver among it. Following: Treiber, Hennecke, Helbing, Congested traffic states in
//! empirical observations and microscopic simulations, Phys. Rev. E 62 (2000), equations 3 and 4. Braking:
//! [`ReferenceDriver`].

use clap::ValueEnum;
use perception_sim::radar::scene::Ego;
use perception_sim::traffic::Traffic;
use perception_sim::vehicle::Vehicle;
use plant::ahead::{Ahead, required_deceleration};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use supervise::ReferenceDriver;

const STEP_NS: u64 = 10_000_000;
const STEP_S: f64 = 0.01;

/// Clearance that the driver must keep, m. Chosen: below it verdicts depend on the step.
pub const CLEARANCE_M: f64 = 0.5;

/// Largest magnitude of a value, tolerances. Margins on an empty road are infinite.
pub(crate) const MOST: f64 = 200.0;

/// Braking that the driver needs before it acts, m/s².
const NEED_MPS2: f64 = ReferenceDriver::NEED_MPS2;
/// Need at which it stops braking hard, m/s². Chosen: comfortable.
const OVER_MPS2: f64 = 1.0;

/// Following: largest acceleration, m/s². Chosen.
const ACCELERATION_MPS2: f64 = 1.5;
/// Following: comfortable deceleration, m/s². Chosen, as for an attentive driver.
const COMFORT_MPS2: f64 = 2.0;
/// Following: time gap, s. Chosen: shorter than what the laws keep.
const TIME_GAP_S: f64 = 1.0;
/// Following: gap at standstill, m. Chosen.
const STANDSTILL_M: f64 = 2.0;

/// Names of the drivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReferenceName {
    /// 6 m/s², 0.35 s after the need
    #[default]
    Regulation,
    /// The careful driver of UN R157: 0.774 g after 0.75 s
    Careful,
    /// No driver: every scene counts
    None,
}

/// The drive of a reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Driven {
    /// Smallest gap to what was in its path, m; negative after a contact, infinite on an empty road.
    pub clearance_m: f64,
    pub samples: Vec<Sample>,
}

/// The driver at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub time_s: f64,
    pub speed_mps: f64,
    /// Gap to the vehicle ahead, m.
    pub gap_m: Option<f64>,
}

impl Driven {
    /// The driver avoids the scene.
    pub fn avoids(&self) -> bool {
        self.clearance_m > CLEARANCE_M
    }

    /// Value of the scene by the driver alone, in tolerances of 0.5 m. It is above 0 where the driver does not avoid
    /// it.
    pub fn value(&self) -> f64 {
        ((CLEARANCE_M - self.clearance_m) / 0.5).clamp(-MOST, MOST)
    }
}

impl ReferenceName {
    pub fn driver(self) -> Option<ReferenceDriver> {
        match self {
            Self::Regulation => Some(ReferenceDriver::REGULATION),
            Self::Careful => Some(ReferenceDriver::CAREFUL),
            Self::None => None,
        }
    }
}

/// Drives a scenario, until its end or a contact. `keep` keeps the samples.
pub fn drive(driver: ReferenceDriver, scenario: &Scenario, keep: bool) -> Driven {
    let mut traffic = Traffic::new(scenario);
    let mut ego = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
    let length_m = scenario.plant.length_m.value();
    let limit = scenario.speed_limit_mps.map_or(f64::INFINITY, |limit| limit.value());
    let wanted_mps = scenario.set_speed_mps.value().min(limit).max(1.0);
    let driver = driver.with_brakes(-scenario.plant.min_acceleration_mps2.value());
    let mut driven = Driven { clearance_m: f64::INFINITY, samples: Vec::new() };
    let mut needed_since: Option<f64> = None;
    let steps = scenario.duration_s.nanoseconds() / STEP_NS;
    for step in 0..=steps {
        let (time_ns, time_s) = (step * STEP_NS, step as f64 * STEP_S);
        traffic.advance(time_ns, &ego);
        let ahead = nearest(traffic.vehicles(), &ego, length_m);
        let gap_m = ahead.map(|vehicle| vehicle.rear_position_m - ego.position_m);
        driven.clearance_m = driven.clearance_m.min(gap_m.unwrap_or(f64::INFINITY));
        if keep {
            driven.samples.push(Sample { time_s, speed_mps: ego.speed_mps, gap_m });
        }
        if gap_m.is_some_and(|gap| gap <= 0.0) {
            break;
        }
        let need_mps2 = ahead.map_or(0.0, |vehicle| needs(&ego, vehicle));
        match needed_since {
            None if need_mps2 > NEED_MPS2 => needed_since = Some(time_s),
            Some(_) if need_mps2 < OVER_MPS2 => needed_since = None,
            _ => {}
        }
        let acceleration_mps2 = match needed_since.map(|since| driver.braking_mps2(time_s - since))
        {
            None => follow(&ego, ahead, wanted_mps),
            // Until it reacts, the driver does what it did, and does not speed up.
            Some(None) => ego.acceleration_mps2.min(0.0),
            Some(Some(braking_mps2)) => -braking_mps2,
        };
        let next_mps = (ego.speed_mps + acceleration_mps2 * STEP_S).max(0.0);
        ego.position_m += 0.5 * STEP_S * (ego.speed_mps + next_mps);
        ego.acceleration_mps2 = acceleration_mps2;
        ego.speed_mps = next_mps;
    }
    driven
}

/// The vehicle in the path that is ahead, or beside the ego's own body.
fn nearest<'a>(vehicles: &'a [Vehicle], ego: &Ego, length_m: f64) -> Option<&'a Vehicle> {
    let is_ahead = |vehicle: &&Vehicle| {
        vehicle.in_ego_path()
            && vehicle.rear_position_m + vehicle.length_m > ego.position_m - length_m
    };
    let rear = |vehicle: &&Vehicle| vehicle.rear_position_m;
    vehicles.iter().filter(is_ahead).min_by(|a, b| rear(a).total_cmp(&rear(b)))
}

/// Even braking that avoids a vehicle which goes on as it does, m/s².
fn needs(ego: &Ego, vehicle: &Vehicle) -> f64 {
    let ahead = Ahead {
        gap_m: vehicle.rear_position_m - ego.position_m,
        speed_mps: vehicle.speed_mps,
        acceleration_mps2: vehicle.acceleration_mps2,
    };
    required_deceleration(ego.speed_mps, &ahead)
}

fn follow(ego: &Ego, ahead: Option<&Vehicle>, wanted_mps: f64) -> f64 {
    let speed_mps = ego.speed_mps;
    let free = 1.0 - squared(squared(speed_mps / wanted_mps));
    let near = ahead.map_or(0.0, |vehicle| {
        let gap_m = (vehicle.rear_position_m - ego.position_m).max(0.1);
        let closing = speed_mps * (speed_mps - vehicle.speed_mps)
            / (2.0 * (ACCELERATION_MPS2 * COMFORT_MPS2).sqrt());
        let desired_m = STANDSTILL_M + (speed_mps * TIME_GAP_S + closing).max(0.0);
        squared(desired_m / gap_m)
    });
    (ACCELERATION_MPS2 * (free - near)).clamp(-NEED_MPS2, ACCELERATION_MPS2)
}

fn squared(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn driven(driver: ReferenceDriver, text: &str) -> Driven {
        let text = format!(
            "schema_version = 1\nname = \"x\"\nduration_s = 20\nset_speed_mps = 20\n\
             [plant]\ninitial_speed_mps = 20\n{text}"
        );
        drive(driver, &Scenario::parse("x.toml", &text).expect("a scenario"), true)
    }

    fn standing(gap_m: f64, appears_s: f64) -> String {
        format!(
            "[[actors]]\nname = \"car\"\ngap_m = {gap_m}\ninitial_speed_mps = 0\nappears_at_s = {appears_s}\n"
        )
    }

    /// It appears ahead of the ego, which keeps its speed. From 20 m/s: 7 m in 0.35 s, then 400/12 = 33.3 m. Or 15 m in
    /// 0.75 s, 11.5 m while the braking grows, then 20.7 m. 0.5 m must be left.
    #[test]
    fn the_driver_brakes_after_its_reaction_time() {
        let avoids = |driver, gap_m| driven(driver, &standing(gap_m, 1.0)).avoids();
        assert!(
            avoids(ReferenceDriver::REGULATION, 41.3) && !avoids(ReferenceDriver::REGULATION, 40.3)
        );
        assert!(avoids(ReferenceDriver::CAREFUL, 48.5) && !avoids(ReferenceDriver::CAREFUL, 47.0));
    }

    #[test]
    fn the_driver_follows_a_vehicle_that_stops_gently() {
        let text = "[[actors]]\nname = \"car\"\ngap_m = 30\ninitial_speed_mps = 20\n\
            profile.steps = [{ time_s = 2, speed_mps = 0, acceleration_mps2 = 2 }]\n";
        let driven = driven(ReferenceDriver::REGULATION, text);
        assert!(driven.avoids() && driven.clearance_m > 1.0, "{}", driven.clearance_m);
    }

    #[test]
    fn an_object_beside_the_lane_is_not_in_the_way() {
        let text = standing(60.0, 0.0) + "lateral_offset_m = 3.5\n";
        let driven = driven(ReferenceDriver::REGULATION, &text);
        assert_eq!(driven.clearance_m, f64::INFINITY);
        assert!(driven.avoids() && driven.value() < 0.0);
        assert_eq!(driven.samples.len(), 2001);
    }
}
