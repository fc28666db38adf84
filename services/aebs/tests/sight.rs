//! Report of the emergency brake on its own sight, from the radar's detections.

use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::radar::detections::DetectionRadar;
use perception_sim::radar::scene::{Ego, Scene};
use perception_sim::vehicle::Vehicle;
use scenario::Scenario;

const PERIOD_NS: i64 = 50_000_000;

/// Share of the scans, from 2 s on, in which the emergency brake is blind behind a lead.
fn blind_share(dropout: f64, seed: u64) -> f64 {
    let text = format!(
        "schema_version = 1\nname = \"x\"\nseed = {seed}\n[perception.radar]\n\
        dropout_probability = {dropout:?}\n"
    );
    let scenario = Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    let (mut radar, mut sight) = (DetectionRadar::new(&scenario), aebs::sight(&scenario));
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let mut blind = 0;
    for scan in 0..240 {
        let ego =
            Ego { position_m: 20.0 * 0.05 * scan as f64, speed_mps: 20.0, acceleration_mps2: 0.0 };
        let lead = Vehicle {
            present: true,
            rear_position_m: ego.position_m + 30.0,
            speed_mps: 20.0,
            length_m: 4.5,
            width_m: 1.8,
            ..Vehicle::default()
        };
        let scene = Scene::new(scan * PERIOD_NS, ego, &[lead]);
        let received = radar.scan(None, &scene, &mut detections);
        sight.take_scan(scan * PERIOD_NS, &detections[..received.count]);
        blind += u32::from(scan >= 40 && sight.is_blind);
    }
    f64::from(blind) / 200.0
}

#[test]
fn a_radar_that_sees_is_never_reported_blind() {
    for dropout in [0.0, 0.1, 0.3] {
        for seed in 0..8 {
            assert_eq!(blind_share(dropout, seed), 0.0, "{dropout}, seed {seed}");
        }
    }
}

#[test]
fn a_radar_that_sees_little_or_nothing_is_reported_blind() {
    for dropout in [0.85, 1.0] {
        for seed in 0..8 {
            let share = blind_share(dropout, seed);
            assert!(share > 0.9, "{dropout}, seed {seed}: {share}");
        }
    }
}
