//! The emergency brake in an everyday scene, scan by scan: its objects and its demand.
//!
//! ```sh
//! cargo run --release -p standards --example brake_objects -- led-queue 0 --from 2 --until 4
//! ```
//!
//! The scene is driven once. The radar then sees the same drive again, with the same seed.

use aebs::decision::Decision;
use aebs::prediction::Ego as OwnMotion;
use bytemuck::Zeroable;
use clap::Parser;
use controller::laws;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::radar::detections::DetectionRadar;
use perception_sim::radar::scene::{Ego, Scene};
use perception_sim::vehicle::Vehicle;
use scenario::{Overrides, Scenario};
use standards::everyday::Kind;
use standards::everyday::scene::{Actor, CAR_WIDTH_M};

/// Periods of the plant between two scans.
const SCAN_STEPS: usize = 5;

#[derive(Debug, Parser)]
struct Arguments {
    /// Kind of the scene
    #[arg(value_enum)]
    kind: Kind,
    /// Its number
    number: u32,
    /// Law that drives
    #[arg(long, default_value = "acc-mpc")]
    law: String,
    /// Start of what is printed, s
    #[arg(long, default_value_t = 0.0)]
    from: f64,
    /// End of what is printed, s
    #[arg(long, default_value_t = f64::INFINITY)]
    until: f64,
    /// Detections as well
    #[arg(long)]
    detections: bool,
}

fn vehicle(actor: &Actor, time_s: f64) -> Vehicle {
    let place = actor.at(time_s);
    let soon_m = actor.at(time_s + 1e-4).lateral_m;
    Vehicle {
        present: true,
        rear_position_m: place.rear_m,
        speed_mps: place.speed_mps,
        acceleration_mps2: place.acceleration_mps2,
        lateral_m: place.lateral_m,
        lateral_speed_mps: (soon_m - place.lateral_m) / 1e-4,
        length_m: actor.length_m,
        width_m: actor.width_m,
        touches_within_m: 0.5 * (actor.width_m + CAR_WIDTH_M),
    }
}

fn main() {
    let arguments = Arguments::parse();
    let drawn = arguments.kind.scene(arguments.number);
    let text = drawn.text(arguments.number, &arguments.law, true);
    let scenario = Scenario::parse_with("everyday", &text, &Overrides::new(), &laws::check)
        .unwrap_or_else(|error| panic!("{error}"));
    let group = group::in_process::run_unsealed(&scenario, &|| false)
        .unwrap_or_else(|error| panic!("{error}"));
    println!("interventions: {:?}", group.drive.interventions_s);
    let mut radar = DetectionRadar::new(&scenario);
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let (mut objects, mut decision) =
        (aebs::objects(&scenario), Decision::new(aebs::settings(&scenario)));
    let mut sight = aebs::sight(&scenario);
    for step in group.drive.steps.iter().step_by(SCAN_STEPS) {
        let time_ns = (step.time_s * 1e9).round() as i64;
        let ego = Ego {
            position_m: step.position_m,
            speed_mps: step.speed_mps,
            acceleration_mps2: step.acceleration_mps2,
        };
        let others: Vec<_> =
            (drawn.actors.iter()).map(|actor| vehicle(actor, step.time_s)).collect();
        let scene = Scene::new(time_ns, ego, &others);
        let received = radar.scan(&scene, &mut detections);
        let seen = &detections[..received.count];
        sight.take_scan(time_ns, seen);
        objects.expect(sight.expected_share());
        objects.take_scan(time_ns, step.speed_mps, seen);
        let own =
            OwnMotion { speed_mps: step.speed_mps, acceleration_mps2: step.acceleration_mps2 };
        let demand = decision.step(&own, objects.threats(decision.path()));
        if !(arguments.from..=arguments.until).contains(&step.time_s) {
            continue;
        }
        println!(
            "{:.2} s, {:.2} m/s, {:.2} m/s²: {:?} {:.1} m/s², threat {:.1?}",
            step.time_s,
            step.speed_mps,
            step.acceleration_mps2,
            demand.state,
            demand.deceleration_mps2,
            demand.threat
        );
        for (actor, vehicle) in drawn.actors.iter().zip(&scene.vehicles) {
            println!(
                "    {}: {:.1} m, {:.2} m/s, {:.2} m/s², {:.2} m to the left",
                actor.name,
                vehicle.rear_position_m - step.position_m,
                vehicle.speed_mps,
                vehicle.acceleration_mps2,
                vehicle.lateral_m
            );
        }
        for object in objects.threats(decision.path()) {
            println!(
                "  object {:.1} m, {:.2} m/s, {:.2} m/s², {:.2} m ± {:.2} to the left, {:.2} m/s, p {:.2}, length {:.1} m",
                object.distance_m,
                object.speed_mps,
                object.acceleration_mps2,
                object.lateral.position_m,
                object.lateral.position_sigma_m(),
                object.lateral.rate_mps,
                object.probability,
                object.length_m
            );
        }
        for d in seen.iter().filter(|_| arguments.detections) {
            println!(
                "      {:.1} m, {:.2} m/s, {:.4} rad, {:.1} dB",
                d.range_m, d.range_rate_mps, d.azimuth_rad, d.snr_db
            );
        }
    }
}
