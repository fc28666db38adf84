//! Causes of the emergency brake's misses in UN R157's cut-ins: perception or decision.
//!
//! ```sh
//! cargo run --release -p standards --example emergency_brake -- --part low --every 5
//! ```
//!
//! The ego keeps its speed until the emergency brake acts: there is no control law. Three systems drive
//! the same cases beside the regulation's models:
//!
//! * `best`: braking that begins at any scan after the other has begun to move sideways, or never. The best choice
//!   counts: no system with these brakes does better.
//! * `simple`: ideal perception 0.15 s late. It brakes at the last point for objects that overlap the ego's path. It
//!   also brakes for those that will overlap it within 1.2 s and before they are passed.
//! * `aebs`: `services/aebs` on the radar's detections.
//! * `aebs-ideal`: its decision on the true objects.
//! * `--laws`: control laws with the emergency brake, each in its whole group.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::process::ExitCode;

use aebs::decision::{Decision, Demand};
use aebs::object::Object;
use aebs::objects::Objects;
use aebs::prediction::Ego as OwnMotion;
use bytemuck::Zeroable;
use clap::{Parser, ValueEnum};
use group::LawOptions;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::radar::detections::DetectionRadar;
use perception_sim::radar::scene::{Ego, Scene};
use perception_sim::traffic::Traffic;
use perception_sim::vehicle::Vehicle;
use plant::brake::BrakePath;
use scenario::Scenario;
use standards::r157::{Case, Matrix, Scenes, verdict};
use standards::{Model, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, Verdict, contact};

/// Period of the ego's motion, s and ns.
const STEP_S: f64 = 0.01;
const STEP_NS: u64 = 10_000_000;
/// Steps between two scans.
const SCAN_STEPS: u64 = 5;
/// Delay of the simple rule's perception, steps.
const LATE_STEPS: usize = 15;
/// The law of the scenarios in which none drives.
const FIRST_LAW: &str = "acc-mpc";
/// Longest time over which the simple rule carries a lateral motion on, s.
const HORIZON_S: f64 = 1.2;

#[derive(Debug, Parser)]
struct Arguments {
    /// Part of the matrix
    #[arg(long, value_enum, default_value = "low")]
    part: Part,
    /// Every how many cases one is driven
    #[arg(long, default_value_t = 20)]
    every: usize,
    /// The first of them
    #[arg(long, default_value_t = 0)]
    first: usize,
    /// Cases driven at a time
    #[arg(long, default_value = "2")]
    jobs: NonZeroUsize,
    /// Seed of the radar's noise
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// The systems
    #[arg(long, value_enum, value_delimiter = ',', default_value = "best,simple,aebs-ideal,aebs")]
    systems: Vec<System>,
    /// Control laws, which drive with the emergency brake
    #[arg(long, value_delimiter = ',')]
    laws: Vec<String>,
    /// Print the avoidable cases
    #[arg(long)]
    show: bool,
    /// Print the other collisions that the best avoids
    #[arg(long)]
    show_all: bool,
    /// Print what the emergency brake sees and does in one case: ego km/h, other km/h, distance m,
    /// lateral speed in tenths of m/s
    #[arg(long, value_delimiter = ',', num_args = 1)]
    trace: Option<Vec<u32>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    Low,
    High,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum System {
    Best,
    Simple,
    AebsIdeal,
    Aebs,
}

/// The verdicts of the systems and of the laws, by name.
type Verdicts = BTreeMap<String, Verdict>;

impl System {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(case) = &arguments.trace {
        let &[ego_kmh, other_kmh, distance_m, lateral_tenths_mps] = case.as_slice() else {
            return ExitCode::from(2);
        };
        let case = standards::cut_in::Case { ego_kmh, other_kmh, distance_m, lateral_tenths_mps };
        let scenario = scene_of(&Case::CutIn(case), arguments.seed, FIRST_LAW);
        let verdict = drive(&scenario, &mut Aebs::new(&scenario, false, true));
        println!("{case:?}: {verdict:?}");
        return ExitCode::SUCCESS;
    }
    let high = arguments.part == Part::High;
    let of_part = |case: &Case| (case.ego_kmh() > standards::cut_in::LOW_UP_TO_KMH) == high;
    let cases: Vec<Case> = (Matrix::CutIn.cases().into_iter().filter(of_part))
        .skip(arguments.first)
        .step_by(arguments.every.max(1))
        .collect();
    let mut all: Vec<(Case, Verdicts)> = Vec::new();
    std::thread::scope(|scope| {
        let (arguments, cases) = (&arguments, &cases);
        let jobs = arguments.jobs.get();
        // Neighbours are alike: each thread takes its share from all of the matrix.
        let drive_part = move |first: usize| -> Vec<(Case, Verdicts)> {
            let part = cases.iter().skip(first).step_by(jobs);
            part.map(|case| (*case, verdicts(case, arguments))).collect()
        };
        let parts: Vec<_> = (0..jobs).map(|first| scope.spawn(move || drive_part(first))).collect();
        let parts: Vec<_> = (parts.into_iter())
            .map(|part| part.join().expect("a thread that drives does not panic"))
            .collect();
        let longest = parts.first().map_or(0, Vec::len);
        all.extend(
            (0..longest).flat_map(|k| parts.iter().filter_map(move |part| part.get(k).cloned())),
        );
    });
    report(&arguments, &all);
    ExitCode::SUCCESS
}

fn report(arguments: &Arguments, all: &[(Case, Verdicts)]) {
    let hit = |verdict: &Verdict| verdict.is_collision();
    let hits = |case: &Case, model| case.drive(model).is_some_and(|verdict| hit(&verdict));
    let regulation = all.iter().filter(|(case, _)| hits(case, Model::Regulation)).count();
    let masters = |case| !hits(case, Model::CarefulDriver) && !hits(case, Model::Regulation);
    let mastered: Vec<bool> = all.iter().map(|(case, _)| masters(case)).collect();
    let of_both = mastered.iter().filter(|mastered| **mastered).count();
    println!("{} cases, {of_both} mastered by both, regulation hits {regulation}", all.len());
    let systems = arguments.systems.iter().map(|system| system.name());
    for system in systems.chain(arguments.laws.iter().cloned()) {
        let hits: Vec<usize> = (0..all.len()).filter(|&k| hit(&all[k].1[&system])).collect();
        let avoidable = hits.iter().filter(|&&k| mastered[k]).count();
        println!(
            "{system}: {} collisions ({:.3} of regulation's), {avoidable} avoidable ({:.2} %)",
            hits.len(),
            hits.len() as f64 / regulation as f64,
            100.0 * avoidable as f64 / of_both as f64,
        );
        for &k in &hits {
            let best_avoids = all[k].1.get(&System::Best.name()).is_some_and(|best| !hit(best));
            let Case::CutIn(case) = all[k].0 else { continue };
            if (mastered[k] && arguments.show) || (best_avoids && arguments.show_all) {
                println!(
                    "  {},{},{},{} {:?} at {:.1} m/s {} {}",
                    case.ego_kmh,
                    case.other_kmh,
                    case.distance_m,
                    case.lateral_tenths_mps,
                    all[k].1[&system].outcome,
                    all[k].1[&system].impact_speed_mps,
                    if mastered[k] { "mastered" } else { "" },
                    if best_avoids { "best avoids" } else { "" }
                );
            }
        }
    }
}

fn scene_of(case: &Case, seed: u32, law: &str) -> Scenario {
    Scenes::new(seed.into(), LawOptions::default(), Vec::new())
        .scenario(case, law, true)
        .expect("every case is a scenario of every law")
}

fn verdicts(case: &Case, arguments: &Arguments) -> Verdicts {
    let scenario = scene_of(case, arguments.seed, FIRST_LAW);
    let of = |system: &System| match system {
        System::Best => best(&scenario),
        System::Simple => drive(&scenario, &mut Simple::default()),
        System::AebsIdeal => drive(&scenario, &mut Aebs::new(&scenario, true, false)),
        System::Aebs => drive(&scenario, &mut Aebs::new(&scenario, false, false)),
    };
    let of_law = |law: &String| {
        let scenario = scene_of(case, arguments.seed, law);
        let group = group::in_process::run_unsealed(&scenario, &|| false);
        let group = group.expect("the group runs");
        verdict(&group.drive)
    };
    let systems = arguments.systems.iter().map(|system| (system.name(), of(system)));
    systems.chain(arguments.laws.iter().map(|law| (law.clone(), of_law(law)))).collect()
}

/// The world at one step.
#[derive(Clone, Copy, Debug)]
struct View {
    step: u64,
    ego: Ego,
    other: Vehicle,
}

impl View {
    fn gap_m(&self) -> f64 {
        self.other.rear_position_m - self.ego.position_m
    }

    fn clearance_m(&self) -> f64 {
        self.other.lateral_m.abs() - VEHICLE_WIDTH_M
    }
}

/// Source of a braking request, asked once in each step.
trait Brakes {
    /// Deceleration, m/s².
    fn ask(&mut self, view: &View) -> f64;
}

fn drive(scenario: &Scenario, brakes: &mut dyn Brakes) -> Verdict {
    let mut traffic = Traffic::new(scenario);
    let mut path = BrakePath::new(scenario);
    let speed_mps = scenario.plant.initial_speed_mps.value();
    let mut ego = Ego { position_m: 0.0, speed_mps, acceleration_mps2: 0.0 };
    let steps = (scenario.duration_s.value() / STEP_S) as u64;
    for step in 0..steps {
        traffic.advance(step * STEP_NS, &ego);
        let view = View { step, ego, other: traffic.vehicles()[0] };
        let outcome = contact(view.gap_m(), view.clearance_m());
        if outcome.is_collision() {
            let impact_speed_mps = ego.speed_mps - view.other.speed_mps;
            return Verdict { outcome, impact_speed_mps };
        }
        if view.gap_m() <= -2.0 * VEHICLE_LENGTH_M {
            return Verdict::NONE;
        }
        let asked_mps2 = brakes.ask(&view);
        let ceiling = path.step(step * STEP_NS, asked_mps2, ego.acceleration_mps2);
        ego.acceleration_mps2 = ceiling.unwrap_or(0.0).min(0.0);
        let next_mps = (ego.speed_mps + ego.acceleration_mps2 * STEP_S).max(0.0);
        ego.position_m += 0.5 * STEP_S * (ego.speed_mps + next_mps);
        ego.speed_mps = next_mps;
    }
    Verdict::NONE
}

/// Brakes from a step on until it is no faster.
struct From {
    first: u64,
}

impl Brakes for From {
    fn ask(&mut self, view: &View) -> f64 {
        let closing = view.ego.speed_mps > view.other.speed_mps;
        if view.step >= self.first && closing { 8.34 } else { 0.0 }
    }
}

/// The best of all instants at which to begin.
fn best(scenario: &Scenario) -> Verdict {
    let unbraked = drive(scenario, &mut From { first: u64::MAX });
    if !unbraked.outcome.is_collision() {
        return unbraked;
    }
    let moves = scenario.actors[0].lateral.first().map_or(0.0, |motion| motion.time_s.value());
    let first = (moves / STEP_S) as u64;
    let last = (scenario.duration_s.value() / STEP_S) as u64;
    let each = (first + SCAN_STEPS..last).step_by(2 * SCAN_STEPS as usize);
    let mut verdicts = each.map(|first| drive(scenario, &mut From { first }));
    verdicts.find(|verdict| !verdict.outcome.is_collision()).unwrap_or(unbraked)
}

/// Ideal perception, late; brakes at the last point.
#[derive(Default)]
struct Simple {
    seen: Vec<View>,
    brakes: bool,
}

impl Brakes for Simple {
    fn ask(&mut self, view: &View) -> f64 {
        self.seen.push(*view);
        let seen = self.seen[self.seen.len().saturating_sub(LATE_STEPS + 1)];
        let closing_mps = seen.ego.speed_mps - seen.other.speed_mps;
        if closing_mps <= 0.0 {
            self.brakes = false;
        } else {
            let ramp_s: f64 = 8.34 / 12.65;
            let needed_m = closing_mps * (0.1 + 0.5 * ramp_s + 0.5 * closing_mps / 8.34);
            let late_m = closing_mps * 0.01 * LATE_STEPS as f64;
            let inward_mps = -seen.other.lateral_speed_mps * seen.other.lateral_m.signum();
            let overlap_s = seen.clearance_m().max(0.0) / inward_mps.max(1e-9);
            let passed_s = (seen.gap_m() + 2.0 * VEHICLE_LENGTH_M) / closing_mps;
            let in_the_way = overlap_s <= HORIZON_S && overlap_s < passed_s;
            self.brakes |= in_the_way && seen.gap_m() < needed_m + late_m;
        }
        if self.brakes { 8.34 } else { 0.0 }
    }
}

/// `services/aebs`.
struct Aebs {
    radar: Option<DetectionRadar>,
    detections: Box<[Detection; MAX_DETECTIONS]>,
    objects: Objects,
    decision: Decision,
    demand: Demand,
    traces: bool,
}

impl Aebs {
    fn new(scenario: &Scenario, ideal: bool, traces: bool) -> Self {
        Self {
            radar: (!ideal).then(|| DetectionRadar::new(scenario)),
            detections: Box::new([Detection::zeroed(); MAX_DETECTIONS]),
            objects: aebs::objects(scenario),
            decision: Decision::new(aebs::settings(scenario)),
            demand: Demand::default(),
            traces,
        }
    }
}

impl Brakes for Aebs {
    fn ask(&mut self, view: &View) -> f64 {
        if !view.step.is_multiple_of(SCAN_STEPS) {
            return self.demand.deceleration_mps2;
        }
        let ego = OwnMotion {
            speed_mps: view.ego.speed_mps,
            acceleration_mps2: view.ego.acceleration_mps2,
        };
        let time_ns = (view.step * STEP_NS) as i64;
        self.demand = if let Some(radar) = &mut self.radar {
            let scene = Scene::new(time_ns, view.ego, &[view.other]);
            let received = radar.scan(&scene, &mut self.detections);
            let detections = &self.detections[..received.count];
            self.objects.take_scan(time_ns, view.ego.speed_mps, detections);
            self.decision.step(&ego, self.objects.threats(self.decision.path()))
        } else {
            let other = &view.other;
            let inside = view.gap_m() > 0.0;
            let object = Object::at(
                view.gap_m(),
                other.speed_mps,
                other.lateral_m,
                other.lateral_speed_mps,
                0.5 * VEHICLE_WIDTH_M,
            );
            self.decision.step(&ego, inside.then_some(object))
        };
        if self.traces {
            let other = &view.other;
            println!(
                "{:.2} true {:.1} m {:.2} m/s at {:.2} m {:.2} m/s, ego {:.2} {:.2}: {:?}",
                view.step as f64 * STEP_S,
                view.gap_m(),
                other.speed_mps,
                other.lateral_m,
                other.lateral_speed_mps,
                ego.speed_mps,
                ego.acceleration_mps2,
                self.demand
            );
            for object in self.objects.confirmed() {
                println!("      {object:?}");
            }
        }
        self.demand.deceleration_mps2
    }
}
