//! Seeded scenes of traffic.
//!
//! A scene lasts 20 s. It is one of four kinds by its seed. They are a lead of varying speed, a cut-in, dense traffic
//! on three lanes, and a lead that brakes hard. The ego follows the nearest vehicle in its lane by the intelligent
//! driver model.

use perception_sim::radar::scene::Ego;
use perception_sim::random::Random;
use perception_sim::vehicle::Vehicle;
use scenario::{Overrides, Scenario};

/// Period of the radar, ns.
pub const PERIOD_NS: u64 = 50_000_000;
/// Scans of a scene.
pub const SCANS: u64 = 400;

/// A scene by its seed, with the row's keys.
pub fn scene(seed: u32, keys: &[&str]) -> Scenario {
    let mut random = Random::of_run(u64::from(seed), 77);
    let ego_mps = random.between(12.0, 33.0);
    let mut text = format!(
        "schema_version = 1\nname = \"scene\"\nseed = {seed}\nduration_s = 20\n\
         set_speed_mps = {ego_mps}\n[plant]\ninitial_speed_mps = {ego_mps}\n"
    );
    let gap_m = random.between(0.8, 2.0) * ego_mps + 5.0;
    let mut actor = |gap_m: f64, speed_mps: f64, length_m: f64, rest: &str| {
        let name = text.matches("[[actors]]").count();
        text += &format!(
            "[[actors]]\nname = \"a{name}\"\ngap_m = {gap_m}\ninitial_speed_mps = {speed_mps}\n\
             length_m = {length_m}\n{rest}\n"
        );
    };
    match seed % 4 {
        0 => {
            let (period_s, peak) = (random.between(6.0, 20.0), random.between(0.3, 2.0));
            let sine =
                format!("profile.sine = {{ amplitude_mps2 = {peak}, period_s = {period_s} }}");
            actor(gap_m, ego_mps, 4.5, &sine);
        }
        1 => {
            let side = if random.uniform() < 0.5 { 3.5 } else { -3.5 };
            let (begins_s, takes_s) = (random.between(3.0, 10.0), random.between(2.0, 6.0));
            let speed_mps = ego_mps - random.between(-1.0, 4.0);
            let cut_in = format!(
                "lateral_offset_m = {side}\n\
                 lateral = [{{ time_s = {begins_s}, to_m = 0, duration_s = {takes_s} }}]"
            );
            actor(random.between(15.0, 70.0), speed_mps, 4.5, &cut_in);
            actor(gap_m + 60.0, ego_mps, 16.0, "");
        }
        2 => {
            actor(gap_m, ego_mps, 4.5, "");
            for _ in 0..6 {
                let lane = if random.uniform() < 0.5 { 3.5 } else { -3.5 };
                let length_m = if random.uniform() < 0.3 { 16.0 } else { 4.5 };
                let speed_mps = ego_mps + random.between(-5.0, 5.0);
                let offset = format!("lateral_offset_m = {lane}");
                actor(random.between(5.0, 120.0), speed_mps.max(0.0), length_m, &offset);
            }
        }
        _ => {
            let (begins_s, braking) = (random.between(4.0, 10.0), random.between(3.0, 9.0));
            let brakes = format!(
                "profile.steps = [{{ time_s = {begins_s}, speed_mps = {}, \
                 acceleration_mps2 = {braking} }}]",
                random.between(0.0, 0.7) * ego_mps
            );
            actor(gap_m, ego_mps, 4.5, &brakes);
            actor(random.between(20.0, 100.0), ego_mps + 2.0, 4.5, "lateral_offset_m = 3.5");
        }
    }
    let mut overrides = Overrides::new();
    for key in keys {
        let key = match key.strip_prefix('/') {
            Some(key) => key.to_owned(),
            None => format!("perception.radar.detections.{key}"),
        };
        overrides.set(key.parse().unwrap_or_else(|error| panic!("{error}")));
    }
    let scenario = Scenario::parse_with("scene", &text, &overrides, &|_| Ok(Default::default()));
    scenario.unwrap_or_else(|error| panic!("{error}"))
}

/// One period of the intelligent driver model (Treiber, Hennecke and Helbing 2000).
pub fn follow(ego: Ego, set_speed_mps: f64, vehicles: &[Vehicle]) -> Ego {
    let (dt_s, v) = (PERIOD_NS as f64 * 1e-9, ego.speed_mps);
    let ahead = vehicles
        .iter()
        .filter(|vehicle| vehicle.in_ego_path() && vehicle.rear_position_m > ego.position_m)
        .min_by(|a, b| a.rear_position_m.total_cmp(&b.rear_position_m));
    let free = 1.0 - libm::pow(v / set_speed_mps, 4.0);
    let wanted = ahead.map_or(free, |vehicle| {
        let gap_m = (vehicle.rear_position_m - ego.position_m).max(0.5);
        let closing_mps = v - vehicle.speed_mps;
        let desired_m = 3.0 + (1.2 * v + 0.5 * v * closing_mps / (1.5f64 * 2.5).sqrt()).max(0.0);
        free - (desired_m / gap_m) * (desired_m / gap_m)
    });
    let acceleration_mps2 = (1.5 * wanted).clamp(-9.0, 1.5).max(-v / dt_s);
    Ego {
        position_m: ego.position_m + v * dt_s + 0.5 * acceleration_mps2 * dt_s * dt_s,
        speed_mps: (v + acceleration_mps2 * dt_s).max(0.0),
        acceleration_mps2,
    }
}
