//! A point mass that is driven by a simple law, with the emergency brake behind the radar's detections.

use super::kinds::Drive;
use aebs::decision::Decision;
use aebs::prediction::Ego as OwnMotion;
use bytemuck::Zeroable;
use messages::{BrakeState, Detection, MAX_DETECTIONS};
use perception_sim::radar::detections::DetectionRadar;
use perception_sim::radar::scene::{Ego, Scene};
use scenario::Scenario;

/// Period of the motion, s and ns.
const STEP_S: f64 = 0.01;
const STEP_NS: i64 = 10_000_000;
/// Steps between two scans.
const SCAN_STEPS: usize = 5;
/// The brakes: dead time, s, jerk, m/s³, and deceleration, m/s².
const BRAKES: (f64, f64, f64) = (0.1, 12.65, 8.34);
/// Braking that does not avoid what is ahead, m/s²: then there is a need.
const NEED_MPS2: f64 = 2.5;
/// Reaction, s, and braking, m/s², of the careful driver (UN R157, annex 4, appendix 3).
const REACTION_S: f64 = 0.35;
const CAREFUL_MPS2: f64 = 6.0;
/// Braking with which no intervention was needed, m/s².
const GENTLE_MPS2: f64 = 1.5;
/// Longest time that is looked at, s.
const LONGEST_S: f64 = 60.0;
/// Jerk of the law's own braking, m/s³.
const LAW_JERK_MPS3: f64 = 5.0;

/// Result of a drive.
#[derive(Clone, Copy, Debug)]
pub struct Result {
    pub collides: bool,
    pub braked: bool,
    pub is_needless: bool,
    pub careful_driver_collides: bool,
    /// Largest change of the acceleration in a step while the emergency brake is on, m/s².
    pub largest_step_mps2: f64,
}

impl Result {
    pub fn is_avoidable(&self) -> bool {
        self.collides && !self.careful_driver_collides
    }
}

/// The ego and its motion.
#[derive(Clone, Copy)]
struct Motion {
    position_m: f64,
    speed_mps: f64,
}

impl Motion {
    fn step(&mut self, acceleration_mps2: f64) {
        let next = (self.speed_mps + acceleration_mps2 * STEP_S).max(0.0);
        self.position_m += 0.5 * STEP_S * (self.speed_mps + next);
        self.speed_mps = next;
    }

    fn touches(&self, drive: &Drive, time_s: f64) -> bool {
        drive.actors.iter().map(|actor| actor.at(time_s)).any(|vehicle| {
            let behind_m = vehicle.rear_position_m - self.position_m;
            vehicle.in_ego_path() && behind_m < 0.0 && behind_m > -vehicle.length_m - 4.5
        })
    }
}

/// True if a driver who brakes with `braking_mps2` from `from` on collides.
fn driver_collides(drive: &Drive, from: (f64, Motion), braking_mps2: f64) -> bool {
    let (mut time_s, mut ego) = from;
    while ego.speed_mps > 0.0 && time_s < LONGEST_S {
        ego.step(-braking_mps2);
        time_s += STEP_S;
        if ego.touches(drive, time_s) {
            return true;
        }
    }
    false
}

/// 2.5 m/s² from now on does not avoid a vehicle that stays in the path and keeps its motion.
fn is_needed(drive: &Drive, time_s: f64, now: Motion) -> bool {
    drive.actors.iter().map(|actor| actor.at(time_s)).any(|vehicle| {
        let is_ahead = vehicle.rear_position_m + vehicle.length_m > now.position_m;
        if !vehicle.in_ego_path() || !is_ahead {
            return false;
        }
        let (mut ego, mut rear_m, mut speed_mps) =
            (now, vehicle.rear_position_m, vehicle.speed_mps);
        while ego.speed_mps > 0.0 {
            ego.step(-NEED_MPS2);
            let next_mps = (speed_mps + vehicle.acceleration_mps2 * STEP_S).max(0.0);
            rear_m += 0.5 * STEP_S * (speed_mps + next_mps);
            speed_mps = next_mps;
            if rear_m < ego.position_m {
                return true;
            }
        }
        false
    })
}

/// The careful driver takes over 0.35 s after the need, and brakes with 6 m/s².
fn careful_driver_collides(drive: &Drive, trace: &[(f64, Motion)]) -> bool {
    let needed = trace.iter().find(|(time_s, ego)| is_needed(drive, *time_s, *ego));
    let takes_over_s = needed.map_or(f64::INFINITY, |(time_s, _)| time_s + REACTION_S);
    let from = trace.iter().find(|(time_s, _)| *time_s >= takes_over_s);
    from.is_none_or(|from| driver_collides(drive, *from, CAREFUL_MPS2))
}

/// Drives it with the emergency brake.
pub fn drive(drive: &Drive) -> Result {
    let text = format!(
        "schema_version = 1\nname = \"x\"\nseed = {}\n[perception.radar.detections]\n\
        false_alarms_per_scan = {:?}\n[aebs]\nenabled = true\n",
        drive.seed, drive.false_alarms
    );
    let scenario = Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    let mut radar = DetectionRadar::new(&scenario);
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let mut objects = aebs::objects(&scenario);
    let mut decision = Decision::new(aebs::settings(&scenario));
    let mut ego = Motion { position_m: 0.0, speed_mps: drive.ego_mps };
    let (mut law_mps2, mut ceiling, mut asked_s) = (drive.ego_mps2, None::<f64>, 0.0);
    let (mut acceleration, mut asks) = (law_mps2, false);
    let mut trace = Vec::new();
    let mut result = Result {
        collides: false,
        braked: false,
        is_needless: false,
        careful_driver_collides: false,
        largest_step_mps2: 0.0,
    };
    let (strength, late_s) = drive.answer;
    for step in 0..(drive.duration_s / STEP_S) as usize {
        let time_s = step as f64 * STEP_S;
        trace.push((time_s, ego));
        if step % SCAN_STEPS == 0 {
            let vehicles: Vec<_> = drive.actors.iter().map(|actor| actor.at(time_s)).collect();
            let scene = Scene::new(
                step as i64 * STEP_NS,
                Ego {
                    position_m: ego.position_m,
                    speed_mps: ego.speed_mps,
                    acceleration_mps2: acceleration,
                },
                &vehicles,
            );
            let received = radar.scan(None, &scene, &mut detections);
            objects.take_scan(
                &aebs::way(&scenario),
                1.0,
                step as i64 * STEP_NS,
                ego.speed_mps,
                &detections[..received.count],
            );
            let own = OwnMotion { speed_mps: ego.speed_mps, acceleration_mps2: acceleration };
            let demand = decision.step(&own, objects.threats(decision.settings.horizon_s));
            asks = demand.deceleration_mps2 > 0.0;
            if asks && !result.braked && demand.state == BrakeState::Braking {
                result.braked = true;
                result.is_needless = !driver_collides(drive, (time_s, ego), GENTLE_MPS2);
            }
        }
        let answers = time_s >= drive.danger_s + late_s;
        let target = if answers { -strength } else { drive.ego_mps2 };
        let reach = LAW_JERK_MPS3 * STEP_S;
        law_mps2 += (target - law_mps2).clamp(-reach, reach);
        asked_s = if asks { asked_s + STEP_S } else { 0.0 };
        let reach = BRAKES.1 * STEP_S;
        ceiling = if asked_s > BRAKES.0 {
            let from = ceiling.map_or(acceleration, |before: f64| before.min(acceleration));
            Some((from - reach).max(-BRAKES.2))
        } else if asks {
            ceiling
        } else {
            ceiling.map(|before| before + reach).filter(|risen| *risen < law_mps2 + reach)
        };
        let before = acceleration;
        acceleration = ceiling.map_or(law_mps2, |ceiling| law_mps2.min(ceiling));
        if ceiling.is_some() && ego.speed_mps > 0.0 {
            result.largest_step_mps2 = result.largest_step_mps2.max((acceleration - before).abs());
        }
        ego.step(acceleration);
        if ego.touches(drive, time_s + STEP_S) {
            result.collides = true;
            result.careful_driver_collides = careful_driver_collides(drive, &trace);
            break;
        }
    }
    result
}
