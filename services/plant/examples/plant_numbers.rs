//! Effect of each number of the plant.
//!
//! ```sh
//! cargo run --release -p plant --example plant_numbers
//! ```
//!
//! Each number is halved and doubled, within its range, while all others keep their values. A car drives a stop-and-go
//! cycle behind a lead. A truck stops on slopes and moves off. A vehicle cuts in, and a car drives through curves.

use bytemuck::Zeroable;
use messages::{AllVehicles, VehicleTruthItem};
use parameters::effect::{Figure, effects};
use plant::ahead::{Ahead, required_with};
use plant::gateway::{Actuation, Source};
use plant::lateral::Lateral;
use plant::longitudinal::{State, Vehicle};
use plant::numbers::Numbers;
use plant::referee::{InPlane, Referee};
use plant::surroundings::Surroundings;
use plant::truck::Truck;
use scenario::Scenario;

/// Period of the plant, ns and s.
const PERIOD_NS: u64 = 10_000_000;
const PERIOD_S: f64 = 0.01;

/// The figures, in the order of [`figures`].
static FIGURES: [Figure; 12] = [
    Figure::value("car's time to 20 m/s", "s", 1e-3),
    Figure::value("energy", "kWh/100 km", 1e-3),
    Figure::value("stops", "", 1e-3),
    Figure::value("least time to collision", "s", 1e-3),
    Figure::value("required deceleration", "m/s²", 1e-3),
    Figure::value("truck's speed on 10 % after a stop", "m/s", 1e-3),
    Figure::value("truck's jerk at a stop", "m/s³", 1e-3),
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
    let (to_20_s, energy, stops, ttc_s, required_mps2) = car(numbers);
    let (rolls_mps, jerk_mps3) = truck(numbers);
    let (begins_s, lasts_s) = cut_in(numbers);
    let [offset_m, across_mps3, slow_m] = curves(numbers);
    vec![
        to_20_s,
        energy,
        stops,
        ttc_s,
        required_mps2,
        rolls_mps,
        jerk_mps3,
        begins_s,
        lasts_s,
        offset_m,
        across_mps3,
        slow_m,
    ]
}

fn scenario(keys: &str) -> Scenario {
    let text = format!("schema_version = 1\nname = \"sensitivity\"\n{keys}\n");
    Scenario::parse("sensitivity", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// A car of limited power pulls away, drives stop and go, and creeps. It is behind a lead that it closes up to at the
/// end.
fn car(numbers: &Numbers) -> (f64, f64, f64, f64, f64) {
    let power = "[plant.powertrain]\nmass_kg = 1600\nmax_power_kw = 30";
    let mut limited = Vehicle::with(&scenario(power).plant, numbers);
    let mut to_20_s = 0.0;
    while limited.state().speed_mps < 20.0 {
        limited.step(5.0);
        to_20_s += PERIOD_S;
    }

    let scenario = scenario("");
    let mut vehicle = Vehicle::with(&scenario.plant, numbers);
    let mut referee = Referee::with(&scenario, numbers);
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
        referee.observe(k * PERIOD_NS, &state, Some(&ahead), &[]);
        required_mps2 = required_mps2.max(required_with(state.speed_mps, &ahead, numbers));
        vehicle.step((1.5 * (wanted_mps - state.speed_mps)).clamp(-3.0, 2.0));
    }
    let figures = referee.figures();
    (
        to_20_s,
        figures.wheel_energy_kwh_per_100km.unwrap_or(f64::NAN),
        figures.stops.unwrap_or(0) as f64,
        figures.min_ttc_s.unwrap_or(f64::NAN),
        required_mps2,
    )
}

/// A truck stops on 10 % uphill and downhill, and its request is then 0. Greatest speed afterwards, and greatest
/// jerk.
fn truck(numbers: &Numbers) -> (f64, f64) {
    let (mut rolls_mps, mut jerk_mps3) = (0.0f64, 0.0f64);
    for percent in [-10.0, 0.0, 10.0] {
        let end_m = 500.0 + 5.0 * percent;
        let scenario = scenario(&format!(
            "plant.vehicle = \"jh6-49t\"\nplant.initial_speed_mps = 10\n\
             road.points = [[0, 500], [500, {end_m}]]"
        ));
        let mut truck = Truck::with(&scenario, numbers).expect("a road").expect("a truck");
        let step = |truck: &mut Truck, request_mps2: f64| {
            let before = truck.state();
            let source = Source::Command;
            truck.step(&Actuation { request_mps2, source, limited: false, engine: None }, None);
            (before, truck.state())
        };
        for _ in 0..3000 {
            let request = -truck.state().speed_mps.clamp(0.0, 2.0) - 0.03;
            let (before, after) = step(&mut truck, request);
            if after.speed_mps > 0.0 && after.speed_mps < 1.0 {
                let change = after.acceleration_mps2 - before.acceleration_mps2;
                jerk_mps3 = jerk_mps3.max((change / PERIOD_S).abs());
            }
        }
        for _ in 0..3000 {
            rolls_mps = rolls_mps.max(step(&mut truck, 0.0).1.speed_mps);
        }
    }
    (rolls_mps, jerk_mps3)
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
        if around.of(&ego, time_s, Some(&truth), None).cut_in {
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
    let mut car = Vehicle::with(&scenario.plant, numbers);
    let mut lateral = Lateral::of(&scenario, numbers).expect("it has a plan");
    let mut referee = Referee::with(&scenario, numbers);
    let (mut fast_m, mut slow_m) = (0.0f64, 0.0f64);
    for k in 0..8000u64 {
        let before = car.state();
        let request = if k < 6000 { 0.0 } else { -2.0 };
        car.step(request);
        if let Some(position_m) = lateral.step(&before, &car.state()) {
            car.place(position_m);
        }
        let state = lateral.state();
        let largest = if k < 6000 { &mut fast_m } else { &mut slow_m };
        *largest = largest.max(state.lateral_m.abs());
        let shown = InPlane {
            lateral_m: state.lateral_m,
            lateral_acceleration_mps2: state.lateral_acceleration_mps2,
            closing_at_contact_mps: None,
        };
        referee.observe_in_plane(k * PERIOD_NS, &car.state(), None, &[], Some(&shown));
    }
    [fast_m, referee.figures().max_abs_lateral_jerk_mps3.unwrap_or(f64::NAN), slow_m]
}
