//! Queues in curves: when it is known whether they stand in the ego's lane.
//!
//! The scenes are those of `timegap test curves`: a curve of 125 to 1,000 m radius, at whose entry or exit six vehicles
//! stand. Here the ego does not brake, so that all see the same. Each scene is driven twice, with the queue in the lane
//! and beside it.

use std::sync::Arc;

use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::random::Random;
use perception_sim::tracking::sources::Sources;
use road::{Axis, Piece};
use scenario::Scenario;

use super::ego;
use super::oracle::Oracle;

/// Gap at which a drive ends, m.
const ENDS_M: f64 = 12.0;
/// Half of the radar's field of view, rad, and its range, m.
const HALF_VIEW_RAD: f64 = std::f64::consts::FRAC_PI_6;
const RANGE_M: f64 = 150.0;
/// Probability from which something is decided.
const SURE: f64 = 0.95;
/// Gap down to which a decision may be taken back, m.
const STAYS_M: f64 = 60.0;
const LANE_M: f64 = 3.5;
const SOURCES: Sources = Sources { yaw_rate: true, standing: true, trails: true, map: false };

struct Scene {
    road: Arc<Axis>,
    scenario: Scenario,
    speed_mps: f64,
    end_m: f64,
}

fn scene(seed: u64, in_lane: bool) -> Scene {
    let mut random = Random::of_run(seed, 31);
    let radius_m = libm::exp(random.between(libm::log(125.0), libm::log(1_000.0)));
    let speed_mps = random.between(0.7, 1.0) * (2.0 * radius_m).sqrt().min(33.0);
    let mut side = || if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    let (curvature_perm, aside) = (side() / radius_m, side());
    let spiral_m = if side() > 0.0 { random.between(30.0, 100.0) } else { 0.0 };
    let length_m = radius_m.clamp(180.0, 400.0);
    let (into_m, behind_m) = (random.between(5.0, 100.0), random.between(-30.0, 60.0));
    let before_m = spiral_m + if seed % 2 == 1 { into_m } else { length_m + behind_m };
    let line_m = (220.0 - before_m).max(60.0);
    let spiral = |start_perm, end_perm| Piece::Spiral { length_m: spiral_m, start_perm, end_perm };
    let mut pieces = vec![Piece::Line { length_m: line_m }];
    if spiral_m > 0.0 {
        pieces.push(spiral(0.0, curvature_perm));
    }
    pieces.push(Piece::Arc { length_m, curvature_perm });
    if spiral_m > 0.0 {
        pieces.push(spiral(curvature_perm, 0.0));
    }
    pieces.push(Piece::Line { length_m: 500.0 });
    let end_m = line_m + before_m;
    let lane_m = if in_lane { 0.0 } else { aside * LANE_M };
    let mut text = format!(
        "schema_version = 1\nname = \"queue\"\nseed = {seed}\n\
         [plant]\ninitial_speed_mps = {speed_mps}\n\
         [perception.radar]\ndropout_probability = 0.02\n"
    );
    let mut rear_m = end_m;
    for index in 0..6 {
        let is_lorry = random.uniform() < 0.2;
        let (length_m, width_m) = if is_lorry { (12.0, 2.5) } else { (4.5, 1.8) };
        let offset_m = lane_m + random.between(-0.3, 0.3);
        text += &format!(
            "[[actors]]\nname = \"queue-{index}\"\ngap_m = {rear_m:.2}\ninitial_speed_mps = 0\n\
             lateral_offset_m = {offset_m:.3}\nlength_m = {length_m}\nwidth_m = {width_m}\n"
        );
        rear_m += length_m + random.between(2.0, 4.0);
    }
    let scenario = Scenario::parse("queue", &text).unwrap_or_else(|error| panic!("{error}"));
    let road = Arc::new(Axis::new(&pieces).expect("a road"));
    Scene { road, scenario, speed_mps, end_m }
}

/// Findings of a drive about the queue's last vehicle.
#[derive(Default)]
struct Seen {
    /// Time since sight, s, and gap, m, at which it was held for in the lane.
    decided: Option<(f64, f64)>,
    /// Gap at which it was last held for possible there, m.
    possible_m: Option<f64>,
    /// Largest braking before a target, m/s²; 0 without one.
    braking_mps2: f64,
    /// Errors of the lane's middle and their standard deviations: gap, error, deviation, m.
    errors: Vec<[f64; 3]>,
}

impl Seen {
    /// Takes a probability of being in the lane, and the place of the lane's middle.
    fn take(&mut self, (after_s, gap_m): (f64, f64), is_in: bool, is_possible: bool) {
        if is_in {
            self.decided = self.decided.or(Some((after_s, gap_m)));
        } else if gap_m > STAYS_M {
            self.decided = None;
        }
        if is_possible {
            self.possible_m = Some(gap_m);
        }
    }
}

/// Drives a scene, with an oracle of `roads` hypotheses beside it.
fn drive(
    scene: &Scene,
    roads: usize,
    seed: u64,
    detections: &mut [Detection; MAX_DETECTIONS],
) -> [Seen; 2] {
    let mut perception = Perception::new(&scene.scenario).on_road(Arc::clone(&scene.road), SOURCES);
    let [mut ours, mut theirs] = [Seen::default(), Seen::default()];
    let (mut oracle, mut sight_s) = (None, None);
    ego::drive(&mut perception, &scene.road, (seed, scene.speed_mps), &[], detections, |scan| {
        let scanned = scan.perception.scanned();
        let plane = scanned.plane.as_ref().expect("a road in the plane");
        let gap_m = scene.end_m - scan.position_m;
        let rear = plane.bodies[0].rear_m;
        let true_m = scanned.vehicles[0].lateral_m;
        let is_seen = rear.0.hypot(rear.1) < RANGE_M && rear.1.atan2(rear.0).abs() < HALF_VIEW_RAD;
        if is_seen && sight_s.is_none() {
            sight_s = Some(scan.time_s);
        }
        let after = sight_s.map(|sight_s| (scan.time_s - sight_s, gap_m));
        if let Some(after) = after {
            let ahead = scan.perception.road_ahead().expect("a tracker");
            let belief = ahead.belief().expect("sources that look ahead");
            let (d_m, sigma_m) = belief.beside_m(rear);
            ours.errors.push([gap_m, d_m - true_m, sigma_m]);
            let target = scan.tracks.target();
            let is_possible = belief.in_way(rear, 0.2, 1.8) > 1.0 - SURE;
            ours.take(after, target.is_some(), is_possible);
            if let Some(target) = target {
                let needed_mps2 = target.relative_speed_mps.powi(2) / (2.0 * target.gap_m.max(1.0));
                ours.braking_mps2 = ours.braking_mps2.max(needed_mps2);
            }
        }
        if roads == 0 {
            return gap_m > ENDS_M && rear.0 > 6.0;
        }
        let oracle =
            oracle.get_or_insert_with(|| Oracle::new(roads, scene.speed_mps, plane.ego.pose));
        let verdict = oracle.take(scan.time_s, &plane.ego.pose, scan.detections, rear);
        if let Some((after, verdict)) = after.zip(verdict) {
            theirs.errors.push([gap_m, verdict.offset_m - true_m, verdict.sigma_m]);
            theirs.take(after, verdict.in_lane > SURE, verdict.in_lane > 1.0 - SURE);
        }
        gap_m > ENDS_M && rear.0 > 6.0
    });
    [ours, theirs]
}

/// Prints the table of some scenes.
pub fn print(count: u64, roads: usize, detections: &mut [Detection; MAX_DETECTIONS]) {
    let mut all: [[Vec<Seen>; 2]; 2] = Default::default();
    let mut speeds_mps = Vec::new();
    for seed in 0..count {
        for (place, in_lane) in [true, false].into_iter().enumerate() {
            let scene = scene(seed, in_lane);
            let seen = drive(&scene, roads, seed, detections);
            all.iter_mut().zip(seen).for_each(|(all, seen)| all[place].push(seen));
            if in_lane {
                speeds_mps.push(scene.speed_mps);
            }
        }
    }
    println!("{count} queues in the lane of a curve, {count} beside it\n");
    println!("| figure | the belief | an oracle of {roads} hypotheses |");
    println!("| --- | --- | --- |");
    let columns = all.map(|[lane, beside]| column(&lane, &beside, &speeds_mps));
    for row in 0..columns[0].len() {
        let [(name, belief), (_, oracle)] = columns.each_ref().map(|all| &all[row]);
        println!("| {name} | {belief} | {oracle} |");
    }
}

/// Figures of one of the two, with their names.
fn column(lane: &[Seen], beside: &[Seen], speeds_mps: &[f64]) -> Vec<(&'static str, String)> {
    let quantile = |values: &mut Vec<f64>, share: f64| {
        values.sort_by(f64::total_cmp);
        let index = ((values.len() as f64 - 1.0) * share).round() as usize;
        values.get(index).copied().unwrap_or(f64::NAN)
    };
    let mut times_s: Vec<f64> =
        lane.iter().filter_map(|seen| seen.decided.map(|decided| decided.0)).collect();
    let decided = times_s.len();
    let mut braking: Vec<f64> = (lane.iter().zip(speeds_mps))
        .filter_map(|(seen, mps)| Some(mps * mps / 2.0 / seen.decided?.1))
        .collect();
    let harder = |limit: f64| braking.iter().filter(|mps2| **mps2 > limit).count();
    let hard = format!("{}, {}", harder(3.0), harder(4.5));
    let mut ruled_m: Vec<f64> =
        beside.iter().map(|seen| seen.possible_m.unwrap_or(RANGE_M)).collect();
    let targets = beside.iter().filter(|seen| seen.braking_mps2 > 0.0).count();
    let braked = beside.iter().filter(|seen| seen.braking_mps2 > 1.5).count();
    let errors = || lane.iter().chain(beside).flat_map(|seen| &seen.errors);
    let mut near_m: Vec<f64> = errors()
        .filter(|[gap_m, ..]| (60.0..80.0).contains(gap_m))
        .map(|[_, error_m, _]| error_m.abs())
        .collect();
    let beyond = errors().filter(|[_, error_m, sigma_m]| error_m.abs() > 3.0 * sigma_m).count();
    let share = 100.0 * beyond as f64 / errors().count().max(1) as f64;
    vec![
        ("in the lane: decided", format!("{decided} of {}", lane.len())),
        (
            "after sight, median (most)",
            format!("{:.1} s ({:.1})", quantile(&mut times_s, 0.5), quantile(&mut times_s, 1.0)),
        ),
        ("braking still needed, median", format!("{:.1} m/s²", quantile(&mut braking, 0.5))),
        ("drives above 3 m/s², 4.5 m/s²", hard),
        (
            "beside: ruled out for good from, median (least)",
            format!("{:.0} m ({:.0})", quantile(&mut ruled_m, 0.5), quantile(&mut ruled_m, 0.0)),
        ),
        ("beside: a target, one that needs 1.5 m/s²", format!("{targets}, {braked}")),
        (
            "|error| of the lane's middle at 60 to 80 m, median (p90)",
            format!("{:.2} m ({:.2})", quantile(&mut near_m, 0.5), quantile(&mut near_m, 0.9)),
        ),
        ("|error| beyond three standard deviations, at all gaps", format!("{share:.1} %")),
    ]
}
