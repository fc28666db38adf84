//! Pictures of trips over distance.

use super::ROAD_M;
use crate::Gallery;
use crate::runner::Driven;
use group::{DriveStep, PowertrainStep};
use report::chart::{Axis, Curve, Plot, Tone};
use scenario::Scenario;
use truck_model::{FUEL_DENSITY_GPL, Preset};

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
            over("Speed", ROAD_M, "km/h", curves(&|step| Some(step.speed_mps * 3.6))),
            over("Engine torque", ROAD_M, "N m", powertrain(|p| p.engine_torque_nm)),
            over("Gear, of the top six", ROAD_M, "", gears),
            over("Fuel", ROAD_M, "L", powertrain(|p| p.fuel_g / FUEL_DENSITY_GPL)),
        ],
    }
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
