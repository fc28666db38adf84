//! When a law with the emergency brake sees what a cut-out uncovers, and when it brakes.
//!
//! ```sh
//! cargo run --release -p regulation --example cut_outs -- --every 7 --laws acc-mpc,quadratic-bounded
//! ```
//!
//! Every case of UN R157's cut-outs is driven by the law, and by `careful-driver` from the gap that the law keeps. A
//! line for each collision that the model avoids gives the instants, in s since the lead began to leave:
//!
//! | instant | meaning |
//! |---|---|
//! | `lead stands` | the lead hits the standing vehicle |
//! | `model` | the model's brakes act: it sees past the lead, or that the lead stands, and 0.8 s later |
//! | `track`, `path`, `target` | the standing vehicle is a confirmed track, one in the path, the law's target |
//! | `object`, `aebs` | it is an object of the emergency brake; that brakes |
//! | `law`, `slows` | the law asks for more than 2 m/s²; the ego slows down with that |
//! | `contact` | speed of the ego over the other at the first contact |
//!
//! A second perception, run over the driven motion, gives the tracks and objects.

use std::num::NonZeroUsize;
use std::process::ExitCode;

use aebs::decision::Decision;
use aebs::prediction::Ego as OwnMotion;
use bytemuck::Zeroable;
use clap::Parser;
use group::Drive;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::radar::scene::Ego;
use regulation::cut_out::{self, VISIBLE_OFFSET_M};
use regulation::r157::drive::Driver;
use regulation::r157::judge::verdict;
use regulation::r157::matrix::{Case, Matrix};
use regulation::r157::scene::{RUN_IN_S, scenario};
use regulation::r157::settled::Settled;
use regulation::{Model, Verdict};
use scenario::Scenario;

/// Steps of the ego's motion between two scans, and its period, ns.
const SCAN_STEPS: u64 = 5;
const STEP_NS: u64 = 10_000_000;
/// Time from when the model sees until its brakes act: eight of its steps, s.
const MODEL_REACTS_S: f64 = 0.8;
/// Braking that counts, m/s².
const BRAKES_MPS2: f64 = 2.0;
/// A track or object so near to the true place and speed of the standing vehicle is one of it, m and m/s.
const SAME: (f64, f64) = (4.0, 3.0);

#[derive(Debug, Parser)]
struct Arguments {
    /// The control laws
    #[arg(long, value_delimiter = ',', default_value = "acc-mpc,quadratic-bounded")]
    laws: Vec<String>,
    /// Every how many cases one is driven
    #[arg(long, default_value = "7")]
    every: NonZeroUsize,
    /// The first of them
    #[arg(long, default_value_t = 0)]
    first: usize,
    /// Cases driven at a time
    #[arg(long, default_value = "2")]
    jobs: NonZeroUsize,
    /// Seed of the radar's noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// End of a case.
struct Driven {
    case: cut_out::Case,
    verdict: Verdict,
    model: Verdict,
    /// Cases in which the law collides.
    instants: Option<Instants>,
}

/// Times since the lead began to leave, s.
#[derive(Debug, Default)]
struct Instants {
    track_s: Option<f64>,
    path_s: Option<f64>,
    target_s: Option<f64>,
    object_s: Option<f64>,
    aebs_s: Option<f64>,
    law_s: Option<f64>,
    slows_s: Option<f64>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let settled = Settled::new(arguments.seed);
    let cases: Vec<cut_out::Case> = (Matrix::CutOut.cases().into_iter())
        .filter_map(|case| match case {
            Case::CutOut(case) => Some(case),
            Case::CutIn(_) | Case::Following(_) => None,
        })
        .skip(arguments.first)
        .step_by(arguments.every.get())
        .collect();
    for law in &arguments.laws {
        let jobs = arguments.jobs.get();
        let mut driven: Vec<Driven> = std::thread::scope(|scope| {
            let (cases, settled) = (&cases, &settled);
            let part = move |first: usize| -> Vec<Driven> {
                let part = cases.iter().skip(first).step_by(jobs);
                part.map(|case| drive(case, law, settled)).collect()
            };
            let parts: Vec<_> = (0..jobs).map(|first| scope.spawn(move || part(first))).collect();
            let join = |part: std::thread::ScopedJoinHandle<'_, Vec<Driven>>| {
                part.join().expect("a thread that drives does not panic")
            };
            parts.into_iter().flat_map(join).collect()
        });
        driven.sort_by_key(|driven| {
            let case = &driven.case;
            (case.speed_kmh, case.standing_distance_m, case.lateral_tenths_mps)
        });
        report(law, &driven);
    }
    ExitCode::SUCCESS
}

fn drive(case: &cut_out::Case, law: &str, settled: &Settled) -> Driven {
    let driver = Driver { law: law.into(), aebs: true };
    let scenario = scenario(&Case::CutOut(*case), &driver, settled);
    let scenario = scenario.expect("every case is a scenario of every law");
    let group = group::in_process::run_unsealed(&scenario, &|| false).expect("the group runs");
    let gap_m = settled.gap_m(law, case.speed_kmh).expect("the law settles");
    let verdict = verdict(&group.drive);
    Driven {
        case: *case,
        verdict,
        model: case.drive_from(Model::CarefulDriver, gap_m),
        instants: verdict.outcome.is_collision().then(|| instants(&scenario, &group.drive)),
    }
}

fn instants(scenario: &Scenario, drive: &Drive) -> Instants {
    let mut instants = Instants::default();
    let mut perception = Perception::new(scenario);
    let mut objects = aebs::objects(scenario);
    let mut decision = Decision::new(aebs::settings(scenario));
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    for step in &drive.steps {
        let time_s = step.time_s - RUN_IN_S;
        let note = |instant: &mut Option<f64>, happens: bool| {
            if happens && time_s >= 0.0 {
                instant.get_or_insert(time_s);
            }
        };
        note(&mut instants.law_s, step.applied_mps2 < -BRAKES_MPS2);
        note(&mut instants.slows_s, step.acceleration_mps2 < -BRAKES_MPS2);
        if !step.step.is_multiple_of(SCAN_STEPS) {
            continue;
        }
        let (speed_mps, acceleration_mps2) = (step.speed_mps, step.acceleration_mps2);
        let ego = Ego { position_m: step.position_m, speed_mps, acceleration_mps2 };
        let list = *perception.step(step.step * STEP_NS, &ego, &mut detections);
        let standing_m = perception.vehicles()[1].rear_position_m - ego.position_m;
        let is_it = |gap_m: f64, ground_mps: f64| {
            (gap_m - standing_m).abs() < SAME.0 && ground_mps.abs() < SAME.1
        };
        for (place, track) in list.tracks().iter().enumerate() {
            let found = is_it(track.gap_m, track.relative_speed_mps + speed_mps);
            note(&mut instants.track_s, found);
            note(&mut instants.path_s, found && track.in_path);
            note(&mut instants.target_s, found && list.target == Some(place));
        }
        let detections = &detections[..perception.received().count];
        objects.take_scan(list.acquisition_ns, speed_mps, detections);
        let found = objects.confirmed().any(|object| is_it(object.distance_m, object.speed_mps));
        note(&mut instants.object_s, found);
        let own = OwnMotion { speed_mps, acceleration_mps2 };
        let demand = decision.step(&own, objects.threats(decision.path()));
        note(&mut instants.aebs_s, demand.deceleration_mps2 > 0.0);
    }
    instants
}

fn report(law: &str, driven: &[Driven]) {
    let hit = |verdict: &Verdict| verdict.outcome.is_collision();
    let mastered = driven.iter().filter(|driven| !hit(&driven.model)).count();
    let avoidable: Vec<&Driven> =
        driven.iter().filter(|driven| hit(&driven.verdict) && !hit(&driven.model)).collect();
    println!(
        "{law}: {} cases, {} collisions, careful-driver from its gap {}; in {} of its {mastered} ({:.2} %), in {} of \
         these the lead hits the standing vehicle",
        driven.len(),
        driven.iter().filter(|driven| hit(&driven.verdict)).count(),
        driven.len() - mastered,
        avoidable.len(),
        100.0 * avoidable.len() as f64 / mastered as f64,
        avoidable.iter().filter(|driven| driven.case.lead_hits()).count(),
    );
    for Driven { case, verdict, instants, .. } in avoidable {
        let Some(instants) = instants else { continue };
        let stands_s = f64::from(case.standing_distance_m) / (f64::from(case.speed_kmh) / 3.6);
        let stands_s = case.lead_hits().then_some(stands_s);
        let sees_s = VISIBLE_OFFSET_M / case.lateral_mps();
        let model_s = stands_s.map_or(sees_s, |stands_s| stands_s.min(sees_s)) + MODEL_REACTS_S;
        let at = |instant: Option<f64>| instant.map_or("-".into(), |s| format!("{s:.2}"));
        println!(
            "  {} km/h, {} m, {:.1} m/s: lead stands {}, model {model_s:.2}; track {}, path {}, target {}, object {}, \
             aebs {}, law {}, slows {}; contact at {:.1} m/s",
            case.speed_kmh,
            case.standing_distance_m,
            case.lateral_mps(),
            at(stands_s),
            at(instants.track_s),
            at(instants.path_s),
            at(instants.target_s),
            at(instants.object_s),
            at(instants.aebs_s),
            at(instants.law_s),
            at(instants.slows_s),
            verdict.impact_speed_mps,
        );
    }
}
