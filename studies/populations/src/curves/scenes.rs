//! Random roads with traffic, and entries and exits of curves with a queue.
//!
//! A random road has a lead and two neighbours:
//!
//! | drawn | from | to |
//! | --- | --- | --- |
//! | radii, m | 250 | 2,000 |
//! | clothoids, m | 30 | 200 |
//! | speed of the ego and mean speed of the others, m/s | 16 | 22.4 |
//! | gap of the lead at the start, m | 30 | 100 |
//! | gap of each neighbour over the lead's | 0.5 | 1.3 |
//! | wave of the lead's speed, amplitude of its acceleration, m/s² | 0.1 | 0.3 |
//! | the same of the neighbours | 0.1 | 0.5 |
//! | period of these waves, s | 12 | 30 |
//!
//! The largest speed gives 2.0 m/s² on the smallest radius, so that no curve changes the gap.
//!
//! A queue has six vehicles, 2 to 4 m apart. It stands left or right of the ego's lane, or in it. Odd numbers are entries
//! of curves, even ones exits:
//!
//! | drawn | from | to |
//! | --- | --- | --- |
//! | radius, m, uniform in its logarithm | 125 | 1,000 |
//! | speed over that of 2.0 m/s² in the curve, at most 33 m/s | 0.7 | 1.0 |
//! | clothoid, m: in one of two curves | 30 | 100 |
//! | entry: end of the queue behind the start of the arc, m | 5 | 100 |
//! | exit: end of the queue behind the end of the arc, m | -30 | 60 |

use std::f64::consts::TAU;

use crate::scene::{Actor, Draws, LANE_M, LateralChange, Scene, fixed};
use scenario::{Setting, Table, table};

/// Select the draws.
const ROADS: u64 = 0xc04e_5ead_0000_5e1d;
const QUEUES: u64 = 0x0c04_e9ee_0e5a_11d5;
/// Length of a drive on a random road, m.
const LENGTH_M: f64 = 5_000.0;
/// Length of the road, km: it reaches beyond the drive as far as the radar sees.
const ROAD_KM: f64 = 5.5;
/// Largest wander of a vehicle in its lane, m.
const WANDER_M: f64 = 0.25;
/// Shortest and longest time between two wanders, s; each takes three quarters of it.
const WANDERS_S: (f64, f64) = (4.0, 8.0);
/// Lateral acceleration that limits the speed, m/s².
const COMFORT_MPS2: f64 = 2.0;
/// Highest speed, m/s.
const FASTEST_MPS: f64 = 33.0;
const VEHICLES: usize = 6;
/// Way before a queue, m: beyond the radar's range.
const APPROACH_M: f64 = 220.0;
/// Shortest and longest arc, m; it is as long as its radius within them.
const ARC_M: (f64, f64) = (180.0, 400.0);
/// Straight road behind the curve, m.
const BEHIND_M: f64 = 500.0;
/// Time for a stop behind a queue, s.
const STOPS_S: f64 = 20.0;

/// A scene on a road in the plane. The ego wanders, and its radar has all of its imperfections.
fn on(mut plan: Table, speed_mps: f64, duration_s: f64) -> Scene {
    let speed_mps = fixed(speed_mps, 3);
    let mut scene = Scene::new(speed_mps, speed_mps, fixed(duration_s, 1));
    plan.extend(table! { lanes: table! { left: 1, right: 1, width_m: LANE_M } });
    scene.keys = vec![
        Setting::new("road.plan", plan),
        Setting::new("plant.lateral.model", "single-track"),
        Setting::new("perception.radar", table! { dropout_probability: 0.02, latency_ms: 50 }),
    ];
    scene
}

pub fn road(number: u64) -> Scene {
    let mut draws = Draws::new(number, ROADS);
    let speed_mps = draws.between(16.0, 22.4);
    let lead_m = draws.between(30.0, 100.0);
    let generated = table! {
        seed: number as i64,
        length_km: ROAD_KM,
        min_radius_m: 250,
        max_radius_m: 2000,
        spiral_m: vec![30, 200],
    };
    let mut scene = on(table! { generated: generated }, speed_mps, LENGTH_M / speed_mps);
    for (name, lane_m, waves_mps2) in
        [("lead", 0.0, 0.3), ("left", LANE_M, 0.5), ("right", -LANE_M, 0.5)]
    {
        let share = if lane_m == 0.0 { 1.0 } else { draws.between(0.5, 1.3) };
        let (length_m, width_m) = draws.size_m();
        let amplitude_mps2 = draws.between(0.1, waves_mps2);
        let period_s = draws.between(12.0, 30.0);
        // The acceleration a sin(2 pi t / T) adds a T / (2 pi) to the mean speed.
        let first_mps = speed_mps - amplitude_mps2 * period_s / TAU;
        let sine = table! {
            amplitude_mps2: fixed(amplitude_mps2, 3),
            period_s: fixed(period_s, 2),
        };
        scene.actors.push(Actor {
            lateral_m: lane_m,
            length_m,
            width_m,
            laterals: wander(&mut draws, lane_m, LENGTH_M / speed_mps),
            keys: table! { profile: table! { sine: sine } },
            ..Actor::car(name, fixed(share * lead_m, 2), fixed(first_mps, 3))
        });
    }
    scene
}

/// The motions of a vehicle that wanders about `lane_m` until `until_s`.
fn wander(draws: &mut Draws, lane_m: f64, until_s: f64) -> Vec<LateralChange> {
    let mut motions = Vec::new();
    let mut time_s = draws.between(0.0, WANDERS_S.0);
    while time_s < until_s {
        let takes_s = draws.between(WANDERS_S.0, WANDERS_S.1);
        let to_m = fixed(lane_m + draws.between(-WANDER_M, WANDER_M), 3);
        let (from_s, lasts_s) = (fixed(time_s, 2), fixed(0.75 * takes_s, 2));
        motions.push(LateralChange { from_s, to_m, lasts_s });
        time_s += takes_s;
    }
    motions
}

/// Queue `number`, in the ego's lane or beside it.
pub fn queue(number: u64, is_in_lane: bool) -> Scene {
    let mut draws = Draws::new(number, QUEUES);
    let radius_m = libm::exp(draws.between(libm::log(125.0), libm::log(1_000.0)));
    let fastest_mps = libm::sqrt(COMFORT_MPS2 * radius_m).min(FASTEST_MPS);
    let speed_mps = draws.between(0.7, 1.0) * fastest_mps;
    let turn = if draws.side() > 0.0 { "left" } else { "right" };
    let spiral_m = draws.chance(0.5).then(|| draws.between(30.0, 100.0));
    let arc_m = radius_m.clamp(ARC_M.0, ARC_M.1);
    let (into_m, behind_m) = (draws.between(5.0, 100.0), draws.between(-30.0, 60.0));
    let bend_m = spiral_m.unwrap_or(0.0);
    let is_entry = number % 2 == 1;
    let before_m = bend_m + if is_entry { into_m } else { arc_m + behind_m };
    let line_m = (APPROACH_M - before_m).max(60.0);
    let lane_m = if is_in_lane { 0.0 } else { LANE_M };
    let lane_m = draws.side() * lane_m;
    let end_m = line_m + before_m;
    let (mut rear_m, mut actors) = (end_m, Vec::new());
    for index in 0..VEHICLES {
        let (length_m, width_m) = draws.size_m();
        let (gap_m, offset_m) = (draws.between(2.0, 4.0), draws.between(-0.3, 0.3));
        let car = Actor::car(format!("queue-{index}"), fixed(rear_m, 2), 0.0);
        actors.push(Actor { lateral_m: fixed(lane_m + offset_m, 3), length_m, width_m, ..car });
        rear_m += length_m + gap_m;
    }
    let spiral = || spiral_m.map(|spiral_m| table! { spiral_m: fixed(spiral_m, 2) });
    let arc = table! { arc_m: fixed(arc_m, 2), radius_m: fixed(radius_m, 2), turn: turn };
    let line = |line_m: f64| Some(table! { line_m: fixed(line_m, 2) });
    let pieces = [line(line_m), spiral(), Some(arc), spiral(), line(BEHIND_M)];
    let plan = table! { pieces: pieces.into_iter().flatten().collect::<Vec<_>>() };
    let (way_m, rest_s) = if is_in_lane { (end_m, STOPS_S) } else { (rear_m + 20.0, 0.0) };
    Scene { actors, ..on(plan, speed_mps, way_m / speed_mps + rest_s) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_makes_the_scene() {
        assert_eq!((road(7), queue(7, true)), (road(7), queue(7, true)));
        assert_ne!(road(7), road(8));
        assert_ne!(queue(7, true), queue(8, true));
    }

    #[test]
    fn roads_are_as_the_table_says() {
        for scene in (1..=300).map(road) {
            assert!((16.0..=22.4).contains(&scene.speed_mps));
            assert!(scene.speed_mps.powi(2) / 250.0 <= 2.01, "no curve slows it down");
            let [lead, left, right] = scene.actors.as_slice() else { panic!("{scene:?}") };
            assert!((30.0..=100.0).contains(&lead.gap_m));
            for beside in [left, right] {
                assert!((0.499..1.301).contains(&(beside.gap_m / lead.gap_m)));
            }
        }
    }

    #[test]
    fn queues_are_as_the_table_says() {
        let all: Vec<Scene> = (1..=400).map(|number| queue(number, false)).collect();
        for scene in &all {
            assert_eq!(scene.actors.len(), VEHICLES);
            assert!(scene.speed_mps <= FASTEST_MPS);
            let end_m = scene.actors[0].gap_m;
            assert!(end_m >= APPROACH_M - 0.01, "it is out of sight at first: {scene:?}");
            let beside = scene.actors.iter().all(|car| (3.2..=3.8).contains(&car.lateral_m.abs()));
            assert!(beside, "{scene:?}");
        }
        let has = |scene: &Scene, word| scene.keys.iter().any(|key| key.to_string().contains(word));
        let with = |word| all.iter().filter(|scene| has(scene, word)).count();
        for (word, what) in [("spiral_m", "clothoids"), ("\"left\"", "turns to the left")] {
            assert!((160..240).contains(&with(word)), "{} with {what}", with(word));
        }
    }
}
