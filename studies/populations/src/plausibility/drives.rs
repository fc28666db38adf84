//! Random drives without faults, of many kinds: a check that finds something in one of them raises a false alarm.
//!
//! A drive is a function of its number alone; the kinds take turns. The ranges are chosen: as wide as public roads and
//! sold radars are, not fitted to what the checks find.

use crate::everyday::{self, Kind};
use crate::scene::{Actor, Draws, Scene, SpeedChange, fixed};
use crate::signals;
use scenario::{Setting, Table, table};

/// Laws that drive a car without signals.
const LAWS: [&str; 4] = ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"];
/// Selects the draws.
const STREAM: u64 = 0x9a5b_11e7;

/// The kinds of drives that no other population has.
const KINDS: [Kind; 10] = [
    ("free-road", free_road),
    ("steady-lead", steady_lead),
    ("ideal-radar", ideal_radar),
    ("object-list", object_list),
    ("wavy-lead", wavy_lead),
    ("clutter", clutter),
    ("signals", signals),
    ("lossy-air", lossy_air),
    ("truck", truck),
    ("cycle", cycle),
];

/// All kinds, in the order in which they take turns. Everyday scenes with an own radar or a fault are left out.
fn kinds() -> impl Iterator<Item = Kind> {
    let draws = || Draws::of(0, 0, 0);
    let everyday = everyday::KINDS.into_iter();
    KINDS.into_iter().chain(everyday.filter(move |(_, draw)| draw(&mut draws()).keys.is_empty()))
}

pub fn kind(number: usize) -> &'static str {
    kind_of(number).0
}

fn kind_of(number: usize) -> Kind {
    kinds().nth(number % kinds().count()).expect("below the number of kinds")
}

/// Drive `number`, as settings of a scenario.
pub fn settings(number: usize) -> Vec<Setting> {
    let (kind, draw) = kind_of(number);
    let mut draws = Draws::new(number as u64, STREAM);
    let mut scene = draw(&mut draws);
    if scene.law.is_empty() {
        let Scene { duration_s, speed_mps, set_mps, actors, .. } = scene;
        scene = Scene { actors, ..car(&mut draws, duration_s, speed_mps, set_mps) };
    }
    scene.settings(&format!("{kind}-{number}"), draws.number + 1)
}

/// A car with a random law, radar and roadside.
fn car(draws: &mut Draws, duration_s: f64, speed_mps: f64, set_mps: f64) -> Scene {
    let law = draws.one(&LAWS);
    let latency_ms = draws.one(&[0, 50, 100]);
    let dropout = if draws.chance(0.5) { draws.between(0.0, 0.1) } else { 0.0 };
    let detections = table! {
        standing_objects_per_km: fixed(draws.between(0.0, 120.0), 1),
        guard_rail_share: fixed(draws.between(0.0, 1.0), 2),
        false_alarms_per_scan: fixed(draws.between(0.0, 3.0), 2),
    };
    let dropout = fixed(dropout, 3);
    let radar = table! {
        latency_ms: latency_ms, dropout_probability: dropout, detections: detections,
    };
    let radar = Setting::new("perception.radar", radar);
    car_with(draws, (duration_s, speed_mps, set_mps), law, radar)
}

/// A car with this law and this radar.
fn car_with(
    draws: &mut Draws,
    (duration_s, speed_mps, set_mps): (f64, f64, f64),
    law: &str,
    radar: Setting,
) -> Scene {
    let engine = table! {
        mass_kg: fixed(draws.between(1_000.0, 2_500.0), 0),
        max_power_kw: fixed(draws.between(60.0, 200.0), 0),
    };
    let lag_s = fixed(draws.between(0.2, 0.6), 2);
    let plant = table! { powertrain: engine, actuator_time_constant_s: lag_s };
    let scene = Scene::new(fixed(speed_mps, 2), fixed(set_mps, 2), fixed(duration_s, 1));
    Scene { law: law.to_owned(), plant, keys: vec![radar], ..scene }
}

/// A lead at a settled gap.
fn lead(draws: &mut Draws, speed_mps: f64) -> Actor {
    let gap_m = 5.0 + draws.between(1.2, 3.0) * speed_mps;
    let length_m = draws.one(&[4.5, 4.5, 12.0, 16.5]);
    Actor { length_m, ..Actor::car("lead", gap_m, speed_mps).fixed() }
}

/// Waves of a lead around `speed_mps`, as keys of its table.
fn waves(draws: &mut Draws, speed_mps: f64) -> Table {
    let period_s = draws.between(6.0, 40.0);
    // Half of the speed's swing is amplitude x period / pi: the lead does not stop.
    let most_mps2 = (2.5 * speed_mps / period_s).min(2.5);
    let amplitude_mps2 = draws.between(0.1 * most_mps2, most_mps2);
    let sine = table! {
        amplitude_mps2: fixed(amplitude_mps2, 3),
        period_s: fixed(period_s, 2),
        start_s: fixed(draws.between(0.0, 10.0), 1),
    };
    table! { profile: table! { sine: sine } }
}

/// A car behind a lead in waves.
fn behind_waves(draws: &mut Draws, scene: Scene, speed_mps: f64) -> Scene {
    let keys = waves(draws, speed_mps);
    scene.with(Actor { keys, ..lead(draws, speed_mps) })
}

fn free_road(draws: &mut Draws) -> Scene {
    let (speed_mps, set_mps) = (draws.between(0.0, 36.0), draws.between(8.0, 38.0));
    car(draws, 60.0, speed_mps, set_mps)
}

fn steady_lead(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(3.0, 34.0);
    car(draws, 60.0, speed_mps, speed_mps + 3.0).with(lead(draws, speed_mps))
}

fn ideal_radar(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = Setting::new("perception.ideal", true);
    let scene = car_with(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    let keys = if draws.chance(0.5) { Table::new() } else { waves(draws, speed_mps) };
    scene.with(Actor { keys, ..lead(draws, speed_mps) })
}

fn object_list(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = table! {
        model: "object-list",
        latency_ms: draws.one(&[0, 50, 100]),
        range_sigma_m: fixed(draws.between(0.05, 0.8), 2),
        range_rate_sigma_mps: fixed(draws.between(0.03, 0.3), 3),
    };
    let radar = Setting::new("perception.radar", radar);
    let scene = car_with(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    behind_waves(draws, scene, speed_mps)
}

fn wavy_lead(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(5.0, 30.0);
    let scene = car(draws, 80.0, speed_mps, speed_mps + 8.0);
    behind_waves(draws, scene, speed_mps)
}

fn clutter(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let dropout = fixed(draws.between(0.0, 0.3), 3);
    let detections = table! {
        false_alarms_per_scan: fixed(draws.between(1.0, 10.0), 1),
        snr_at_100_m_db: fixed(draws.between(8.0, 15.0), 1),
        standing_objects_per_km: fixed(draws.between(50.0, 300.0), 0),
        guard_rail_share: 1,
    };
    let radar = table! { latency_ms: 50, dropout_probability: dropout, detections: detections };
    let radar = Setting::new("perception.radar", radar);
    let scene = car_with(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    behind_waves(draws, scene, speed_mps)
}

fn signals(draws: &mut Draws) -> Scene {
    let law = draws.one(&["cacc-mpc", "acc-signal-stop"]);
    signals::scene(draws.bits().into(), law)
}

fn lossy_air(draws: &mut Draws) -> Scene {
    let mut scene = signals::scene(draws.bits().into(), "cacc-mpc");
    let air = table! {
        loss_probability: fixed(draws.between(0.0, 0.6), 2),
        delay_ms: whole(draws, 0.0, 300.0),
        jitter_ms: whole(draws, 0.0, 200.0),
        duplicate_probability: fixed(draws.between(0.0, 0.3), 2),
        reorder_probability: fixed(draws.between(0.0, 0.3), 2),
        reorder_ms: whole(draws, 0.0, 500.0),
    };
    scene.keys.push(Setting::new("v2x.air", air));
    scene.keys.push(Setting::new("v2x.obu.clock_offset_ms", whole(draws, -150.0, 150.0)));
    scene
}

fn whole(draws: &mut Draws, low: f64, high: f64) -> i64 {
    draws.between(low, high).round() as i64
}

fn truck(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(15.0, 25.0);
    let model = draws.one(&["object-list", "detections"]);
    let mut scene = Scene::new(fixed(speed_mps, 2), fixed(speed_mps + 1.0, 2), 100.0);
    scene.law = "predictive".to_owned();
    scene.plant = table! {
        vehicle: draws.one(&["jh6-49t", "jh6-25t"]),
        period_ms: 20,
        integration_step_ms: 20,
        length_m: 16.5,
        actuator_time_constant_s: 0.4,
        min_acceleration_mps2: -6.5,
    };
    let grades = fixed(draws.between(0.3, 1.5), 2);
    let road = table! { seed: draws.number as i64 + 1, length_km: 8, grade_sigma_percent: grades };
    let perception = table! {
        period_ms: 100,
        radar: table! { model: model, max_range_m: 200 },
    };
    let aebs = table! { dead_time_ms: 300, jerk_mps3: 10, deceleration_mps2: 5.5, margin_m: 3 };
    scene.keys = vec![
        Setting::new("road.generated", road),
        Setting::new("perception", perception),
        Setting::new("aebs", aebs),
        Setting::new("v2x.period_ms", 500),
    ];
    let slows = SpeedChange {
        from_s: fixed(draws.between(10.0, 30.0), 1),
        to_mps: fixed(speed_mps * draws.between(0.4, 1.0), 1),
        rate_mps2: fixed(draws.between(0.3, 2.0), 2),
    };
    let goes = SpeedChange { from_s: 60.0, to_mps: fixed(speed_mps, 1), rate_mps2: 0.5 };
    scene.with(Actor { speeds: vec![slows, goes], ..lead(draws, speed_mps) })
}

fn cycle(draws: &mut Draws) -> Scene {
    let cycle = draws.one(&["udds", "hwfet", "us06", "wltc-3b"]);
    let mut scene = car(draws, 300.0, 0.0, 38.0);
    // Its speeds are those of the cycle from the start on.
    let profile = table! { cycle: cycle };
    scene.others.push(table! { name: "lead", gap_m: 8, profile: profile });
    scene
}
