//! Pictures of trips over distance.

use super::{ROAD_M, SET_SPEED_MPS};
use crate::Gallery;
use crate::runner::Driven;
use controller::law::{MAX_CELLS, Preview};
use controller::laws::truck::{LimitGrades, Reconstruction, RoadKeys};
use group::{DriveStep, PowertrainStep};
use report::chart::{Axis, Curve, Plot, Tone};
use scenario::Scenario;
use truck_model::{FUEL_DENSITY_GPL, Preset, Truck};

/// Distance between two points of a curve, m.
const POINT_M: f64 = 50.0;

/// Height, speed, torque, gear and fuel of trips on the given road.
pub fn trips(preset: Preset, trips: &[(&'static str, &Driven)]) -> Gallery {
    let curves = |value: &dyn Fn(&DriveStep) -> Option<f64>| {
        let curve = |(index, (name, driven)): (usize, &(&str, &Driven))| {
            Curve::new(name, Tone::Series(index), over_distance(driven, ROAD_M, value))
        };
        trips.iter().enumerate().map(curve).collect::<Vec<_>>()
    };
    let powertrain = |value: fn(&PowertrainStep) -> f64| {
        curves(&move |step| step.powertrain.as_ref().map(value))
    };
    let road = trips.first().map_or_else(Vec::new, |(_, driven)| height(&driven.scenario, ROAD_M));
    let gears = powertrain(|p| p.gear.into()).into_iter().map(Curve::steps).collect();
    Gallery {
        heading: format!("{} at 75 km/h", preset.name()),
        plots: vec![
            over("Height", ROAD_M, "m", vec![Curve::new("road", Tone::Muted, road)]),
            over("Slope and its reconstruction (figure 6)", ROAD_M, "%", slopes(preset, trips)),
            over("Speed (figure 7)", ROAD_M, "km/h", curves(&|step| Some(step.speed_mps * 3.6))),
            over("Economic speed (figure 7)", ROAD_M, "km/h", economic(trips)),
            over("Engine torque", ROAD_M, "N m", powertrain(|p| p.engine_torque_nm)),
            over("Gear, of the top six", ROAD_M, "", gears),
            over("Fuel", ROAD_M, "L", powertrain(|p| p.fuel_g / FUEL_DENSITY_GPL)),
        ],
    }
}

/// The road's slope and the stretches that steps 1 and 2 of the planner make of it, horizon by horizon.
fn slopes(preset: Preset, trips: &[(&'static str, &Driven)]) -> Vec<Curve> {
    let road = trips.first().and_then(|(_, driven)| driven.scenario.road.profile().ok());
    let Some(road) = road else { return Vec::new() };
    let keys = RoadKeys::default();
    let limits = LimitGrades::new(&Truck::preset(preset), &keys, SET_SPEED_MPS);
    let percent = |from_m: f64, to_m: f64| 100.0 * road.mean_grade(from_m, to_m);
    let cells = (0..(ROAD_M / POINT_M) as u32).map(|cell| f64::from(cell) * POINT_M);
    let slope = cells.map(|from_m| (from_m / 1e3, percent(from_m, from_m + POINT_M))).collect();
    let mut reconstruction = Reconstruction::new(&keys);
    let (mut rebuilt, mut start_m) = (Vec::new(), 0.0);
    while start_m < ROAD_M {
        let mut preview =
            Preview { start_m, cell_m: POINT_M, count: MAX_CELLS, ..Preview::default() };
        for (cell, grade) in preview.grades.iter_mut().enumerate() {
            let from_m = start_m + POINT_M * cell as f64;
            *grade = road.mean_grade(from_m, from_m + POINT_M);
        }
        reconstruction.rebuild(&preview, start_m, &limits);
        for stretch in reconstruction.stretches() {
            rebuilt.push((start_m / 1e3, 100.0 * stretch.grade));
            start_m += stretch.length_m;
        }
    }
    vec![
        Curve::new("slope", Tone::Muted, slope).steps(),
        Curve::new("reconstruction", Tone::Series(0), rebuilt).steps(),
    ]
}

/// The planners' economic speeds.
fn economic(trips: &[(&'static str, &Driven)]) -> Vec<Curve> {
    let curve = |(index, (name, driven)): (usize, &(&'static str, &Driven))| {
        let figure = driven.figure_names.iter().position(|name| *name == "economic_speed_mps")?;
        let value = move |step: &DriveStep| Some(3.6 * step.figures?[figure]);
        Some(Curve::new(name, Tone::Series(index), over_distance(driven, ROAD_M, &value)))
    };
    // The first trip keeps the set speed.
    trips.iter().enumerate().skip(1).filter_map(curve).collect()
}

/// Curves over the distance to `until_m`.
pub fn over(title: &str, until_m: f64, unit: &str, curves: Vec<Curve>) -> Plot {
    let x = Axis::linear("distance, km", 0.0, until_m / 1e3);
    Plot { x, ..Plot::over_time(title, 1.0, unit, curves) }
}

/// The road's height, m, over distance, km.
pub fn height(scenario: &Scenario, until_m: f64) -> Vec<(f64, f64)> {
    let Ok(road) = scenario.road.profile() else { return Vec::new() };
    let count = (until_m / POINT_M) as u32;
    let place = |index: u32| f64::from(index) * POINT_M;
    (0..=count).map(|index| (place(index) / 1e3, road.height_m(place(index)))).collect()
}

/// A value at one step in each stretch of [`POINT_M`], over distance in km.
pub fn over_distance(
    driven: &Driven,
    until_m: f64,
    value: &dyn Fn(&DriveStep) -> Option<f64>,
) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    let mut next_m = 0.0;
    for step in &driven.drive.steps {
        if step.position_m > until_m {
            break;
        }
        if step.position_m >= next_m
            && let Some(value) = value(step)
        {
            points.push((step.position_m / 1e3, value));
            next_m = (step.position_m / POINT_M).floor() * POINT_M + POINT_M;
        }
    }
    points
}
