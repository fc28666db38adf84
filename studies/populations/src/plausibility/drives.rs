//! Random drives without faults, of many kinds: a check that finds something in one of them raises a false alarm.
//!
//! A drive is a function of its number alone; the kinds take turns. The ranges are chosen: as wide as public roads and
//! sold radars are, not fitted to what the checks find.

use crate::everyday::{self, Kind};
use crate::scene::{Actor, Draws, Scene, SpeedChange, fixed};
use crate::signals;

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
    KINDS.into_iter().chain(everyday.filter(move |(_, draw)| draw(&mut draws()).tables.is_empty()))
}

pub fn kind(number: usize) -> &'static str {
    kind_of(number).0
}

fn kind_of(number: usize) -> Kind {
    kinds().nth(number % kinds().count()).expect("below the number of kinds")
}

/// Drive `number`, as a scenario file.
pub fn text(number: usize) -> String {
    let (kind, draw) = kind_of(number);
    let mut draws = Draws::new(number as u64, STREAM);
    let mut scene = draw(&mut draws);
    if scene.law.is_empty() {
        let Scene { duration_s, speed_mps, set_mps, actors, .. } = scene;
        scene = Scene { actors, ..car(&mut draws, duration_s, speed_mps, set_mps) };
    }
    scene.text(&format!("{kind}-{number}"), draws.number + 1)
}

/// A car with a random law, radar and roadside.
fn car(draws: &mut Draws, duration_s: f64, speed_mps: f64, set_mps: f64) -> Scene {
    let law = draws.one(&LAWS);
    let latency_ms = draws.one(&[0, 50, 100]);
    let dropout = if draws.chance(0.5) { draws.between(0.0, 0.1) } else { 0.0 };
    let radar = format!(
        "[perception.radar]\nlatency_ms = {latency_ms}\ndropout_probability = {dropout:.3}\n\
         [perception.radar.detections]\nstanding_objects_per_km = {:.1}\nguard_rail_share = {:.2}\n\
         false_alarms_per_scan = {:.2}\n",
        draws.between(0.0, 120.0),
        draws.between(0.0, 1.0),
        draws.between(0.0, 3.0),
    );
    car_with(draws, (duration_s, speed_mps, set_mps), law, radar)
}

/// A car with this law and these tables.
fn car_with(
    draws: &mut Draws,
    (duration_s, speed_mps, set_mps): (f64, f64, f64),
    law: &str,
    tables: String,
) -> Scene {
    let plant = format!(
        "powertrain = {{ mass_kg = {:.0}, max_power_kw = {:.0} }}\nactuator_time_constant_s = {:.2}\n",
        draws.between(1_000.0, 2_500.0),
        draws.between(60.0, 200.0),
        draws.between(0.2, 0.6),
    );
    let scene = Scene::new(fixed(speed_mps, 2), fixed(set_mps, 2), fixed(duration_s, 1));
    Scene { law: law.to_owned(), plant, tables, ..scene }
}

/// A lead at a settled gap.
fn lead(draws: &mut Draws, speed_mps: f64) -> Actor {
    let gap_m = 5.0 + draws.between(1.2, 3.0) * speed_mps;
    let length_m = draws.one(&[4.5, 4.5, 12.0, 16.5]);
    Actor { length_m, ..Actor::car("lead", gap_m, speed_mps).fixed() }
}

/// Waves of a lead around `speed_mps`, as a line of its table.
fn waves(draws: &mut Draws, speed_mps: f64) -> String {
    let period_s = draws.between(6.0, 40.0);
    // Half of the speed's swing is amplitude x period / pi: the lead does not stop.
    let most_mps2 = (2.5 * speed_mps / period_s).min(2.5);
    let amplitude_mps2 = draws.between(0.1 * most_mps2, most_mps2);
    format!(
        "profile.sine = {{ amplitude_mps2 = {amplitude_mps2:.3}, period_s = {period_s:.2}, start_s = {:.1} }}\n",
        draws.between(0.0, 10.0)
    )
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
    let radar = "[perception]\nideal = true\n".to_owned();
    let scene = car_with(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    let keys = if draws.chance(0.5) { String::new() } else { waves(draws, speed_mps) };
    scene.with(Actor { keys, ..lead(draws, speed_mps) })
}

fn object_list(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(5.0, 30.0);
    let law = draws.one(&LAWS);
    let radar = format!(
        "[perception.radar]\nmodel = \"object-list\"\nlatency_ms = {}\nrange_sigma_m = {:.2}\n\
         range_rate_sigma_mps = {:.3}\n",
        draws.one(&[0, 50, 100]),
        draws.between(0.05, 0.8),
        draws.between(0.03, 0.3),
    );
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
    let radar = format!(
        "[perception.radar]\nlatency_ms = 50\ndropout_probability = {:.3}\n\
         [perception.radar.detections]\nfalse_alarms_per_scan = {:.1}\nsnr_at_100_m_db = {:.1}\n\
         standing_objects_per_km = {:.0}\nguard_rail_share = 1\n",
        draws.between(0.0, 0.3),
        draws.between(1.0, 10.0),
        draws.between(8.0, 15.0),
        draws.between(50.0, 300.0),
    );
    let scene = car_with(draws, (60.0, speed_mps, speed_mps + 3.0), law, radar);
    behind_waves(draws, scene, speed_mps)
}

fn signals(draws: &mut Draws) -> Scene {
    let law = draws.one(&["cacc-mpc", "acc-signal-stop"]);
    signals::scene(draws.bits().into(), law)
}

fn lossy_air(draws: &mut Draws) -> Scene {
    let mut scene = signals::scene(draws.bits().into(), "cacc-mpc");
    scene.tables += &format!(
        "[v2x.air]\nloss_probability = {:.2}\ndelay_ms = {:.0}\njitter_ms = {:.0}\n\
         duplicate_probability = {:.2}\nreorder_probability = {:.2}\nreorder_ms = {:.0}\n\
         [v2x.obu]\nclock_offset_ms = {:.0}\n",
        draws.between(0.0, 0.6),
        draws.between(0.0, 300.0),
        draws.between(0.0, 200.0),
        draws.between(0.0, 0.3),
        draws.between(0.0, 0.3),
        draws.between(0.0, 500.0),
        draws.between(-150.0, 150.0),
    );
    scene
}

fn truck(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(15.0, 25.0);
    let model = draws.one(&["object-list", "detections"]);
    let filter = draws.one(&["singer", "interacting-models"]);
    let mut scene = Scene::new(fixed(speed_mps, 2), fixed(speed_mps + 1.0, 2), 100.0);
    scene.law = "predictive".to_owned();
    scene.plant = format!(
        "vehicle = \"{}\"\nperiod_ms = 20\nintegration_step_ms = 20\nlength_m = 16.5\n\
         actuator_time_constant_s = 0.4\nmin_acceleration_mps2 = -6.5\n",
        draws.one(&["jh6-49t", "jh6-25t"]),
    );
    scene.tables = format!(
        "[road.generated]\nseed = {}\nlength_km = 8\ngrade_sigma_percent = {:.2}\n\
         [perception]\nperiod_ms = 100\nradar = {{ model = \"{model}\", max_range_m = 200 }}\n\
         tracker = {{ filter = \"{filter}\" }}\n\
         [aebs]\ndead_time_ms = 300\njerk_mps3 = 10\ndeceleration_mps2 = 5.5\nmargin_m = 3\n\
         [v2x]\nperiod_ms = 500\n",
        draws.number + 1,
        draws.between(0.3, 1.5),
    );
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
    scene.tables +=
        &format!("[[actors]]\nname = \"lead\"\ngap_m = 8.00\nprofile.cycle = \"{cycle}\"\n");
    scene
}
