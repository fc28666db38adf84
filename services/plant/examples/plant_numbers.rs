//! Effect of each number of the plant.
//!
//! ```sh
//! cargo run --release -p plant --example plant_numbers
//! ```
//!
//! Each number is halved and doubled, within its range, while all others keep their values. A car drives a stop-and-go
//! cycle behind a lead. A vehicle cuts in, and a car drives through curves.

use bytemuck::Zeroable;
use messages::{AllVehicles, VehicleTruthItem};
use parameters::effect::{Figure, effects};
use plant::ahead::{Ahead, required_with};
use plant::lateral::Lateral;
use plant::longitudinal::{State, Vehicle};
use plant::numbers::Numbers;
use plant::referee::{InPlane, Referee};
use plant::surroundings::Surroundings;
use scenario::Scenario;

/// Period of the plant, ns and s.
const PERIOD_NS: u64 = 10_000_000;
const PERIOD_S: f64 = 0.01;

/// The figures, in the order of [`figures`].
static FIGURES: [Figure; 8] = [
    Figure::value("energy", "kWh/100 km", 1e-3),
    Figure::value("stops", "", 1e-3),
    Figure::value("required deceleration", "m/s²", 1e-3),
    Figure::value("cut-in begins", "s", 1e-3),
    Figure::value("cut-in lasts", "s", 1e-3),
    Figure::value("offset in curves", "m", 0.02),
    Figure::value("lateral jerk in curves", "m/s³", 0.02),
    Figure::value("offset before a stand in a curve", "m", 0.02),
];

fn main() {
    let base = figures(&Numbers::DEFAULT);
    for (figure, value) in FIGURES.iter().zip(&base) {
        println!("{}", figure.text(*value));
    }
    effects(&Numbers::DEFAULT, &FIGURES, &base, figures).for_each(|line| println!("{line}"));
}

fn figures(numbers: &Numbers) -> Vec<f64> {
    let (energy, stops, required_mps2) = car(numbers);
    let (begins_s, lasts_s) = cut_in(numbers);
    let [offset_m, across_mps3, slow_m] = curves(numbers);
    vec![energy, stops, required_mps2, begins_s, lasts_s, offset_m, across_mps3, slow_m]
}

fn scenario(keys: &str) -> Scenario {
    let text = format!("schema_version = 1\nname = \"sensitivity\"\n{keys}\n");
    Scenario::parse("sensitivity", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// A car drives stop and go, and creeps. It is behind a lead that it closes up to at the end.
fn car(numbers: &Numbers) -> (f64, f64, f64) {
    let scenario = scenario("");
    let mut vehicle = Vehicle::new(&scenario.plant);
    let mut referee = Referee::new(&scenario, numbers);
    let mut lead_m = 80.0;
    let mut required_mps2 = 0.0f64;
    for k in 0..18_000u64 {
        let time_s = k as f64 * PERIOD_S;
        let state = vehicle.state();
        // Stops and pulls away every 30 s, then creeps at 0.7 m/s between two stands, then at 0.35 m/s.
        let wanted_mps: f64 = match time_s {
            ..120.0 if time_s % 30.0 < 20.0 => 13.0,
            125.0..130.0 => 0.7,
            135.0..140.0 => 0.35,
            150.0..170.0 => 13.0,
            _ => 0.0,
        };
        let lead_mps = if time_s > 160.0 { wanted_mps.min(10.0) } else { state.speed_mps };
        lead_m += lead_mps * PERIOD_S;
        let ahead =
            Ahead { gap_m: lead_m - state.position_m, speed_mps: lead_mps, acceleration_mps2: 0.0 };
        referee.observe(k * PERIOD_NS, &state, Some(&ahead), [], None);
        required_mps2 = required_mps2.max(required_with(state.speed_mps, &ahead, numbers));
        vehicle.step((1.5 * (wanted_mps - state.speed_mps)).clamp(-3.0, 2.0));
    }
    let figures = referee.figures();
    (
        figures.wheel_energy_kwh_per_100km.unwrap_or(f64::NAN),
        figures.stops.unwrap_or(0) as f64,
        required_mps2,
    )
}

/// A vehicle comes over from the second lane beside, 60 m ahead. When the phase begins, and for how long it lasts.
fn cut_in(numbers: &Numbers) -> (f64, f64) {
    let actor = "[[actors]]\nname = \"a\"\ngap_m = 60\ninitial_speed_mps = 10";
    let mut around = Surroundings::new(&scenario(actor), numbers);
    let (mut begins_s, mut lasts_s) = (f64::NAN, 0.0);
    for k in 0..2000u64 {
        let time_s = k as f64 * PERIOD_S;
        let mut truth = AllVehicles::with_room(1);
        truth.header.acquisition_ns = (k * PERIOD_NS) as i64;
        truth.vehicles.push(VehicleTruthItem::zeroed());
        // The lateral speed rises from 0 to 1 m/s in the middle and falls again.
        let phase = (time_s / 12.0).min(1.0) * std::f64::consts::PI;
        truth.vehicles[0].lateral_m = 3.5 * (1.0 + libm::cos(phase));
        truth.vehicles[0].rear_position_m = 60.0;
        let ego = State::default();
        if around.of(&ego, time_s, Some(&truth), None).cut_in != 0 {
            begins_s = if lasts_s > 0.0 { begins_s } else { time_s };
            lasts_s += PERIOD_S;
        }
    }
    (begins_s, lasts_s)
}

/// A car drives through narrow curves at 14 m/s for 60 s, then brakes to a stand in one. Largest offset from the axis in
/// both parts, and the largest lateral jerk.
fn curves(numbers: &Numbers) -> [f64; 3] {
    let scenario = scenario(
        "plant.initial_speed_mps = 14\n[road.plan]\n\
         generated = { seed = 5, length_km = 2, min_radius_m = 100, max_radius_m = 400 }",
    );
    let mut car = Vehicle::new(&scenario.plant);
    let mut lateral = Lateral::of(&scenario, numbers).expect("it has a plan");
    let mut referee = Referee::new(&scenario, numbers);
    let (mut fast_m, mut slow_m) = (0.0f64, 0.0f64);
    for k in 0..8000u64 {
        let before = car.state();
        let request = if k < 6000 { 0.0 } else { -2.0 };
        car.step(request);
        if let Some(position_m) = lateral.step(&before, &car.state()) {
            car.place(position_m);
        }
        let state = lateral.state;
        let largest = if k < 6000 { &mut fast_m } else { &mut slow_m };
        *largest = largest.max(state.lateral_m.abs());
        let shown = InPlane {
            lateral_m: state.lateral_m,
            lateral_acceleration_mps2: state.lateral_acceleration_mps2,
            closing_at_contact_mps: None,
        };
        referee.observe(k * PERIOD_NS, &car.state(), None, [], Some(&shown));
    }
    [fast_m, referee.figures().max_abs_lateral_jerk_mps3.unwrap_or(f64::NAN), slow_m]
}
