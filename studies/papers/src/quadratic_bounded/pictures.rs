//! Figures 3 to 5: distance, speed, acceleration, and the two pedals of the inverse model.

use super::actuators::{Pedals, pedals};
use crate::Gallery;
use crate::runner::Driven;
use group::DriveStep;
use report::chart::{Curve, Plot, Stroke, Tone};

/// The pedals over a drive: time in s, and what they do.
pub fn pressed(driven: &Driven) -> Vec<(f64, Pedals)> {
    let press = |step: &DriveStep| (step.time_s, pedals(step.speed_mps, step.acceleration_mps2));
    driven.drive.steps.iter().map(press).collect()
}

/// The figure of a scenario, with one curve for each set.
pub fn figure(number: u32, name: &str, sets: &[(&'static str, &Driven)]) -> Gallery {
    let until_s = sets.iter().filter_map(|(_, driven)| driven.drive.steps.last());
    let until_s = until_s.map(|step| step.time_s).fold(0.0, f64::max);
    let curves = |value: &dyn Fn(&DriveStep) -> f64| -> Vec<Curve> {
        let draw = |(index, (set, driven)): (usize, &(&'static str, &Driven))| {
            let points = driven.drive.steps.iter().map(|step| (step.time_s, value(step)));
            let curve = Curve::new(set, Tone::Series(index), points.collect());
            if index == 0 { curve } else { curve.stroke(Stroke::Dashed) }
        };
        sets.iter().enumerate().map(draw).collect()
    };
    let plot = |title: &str, unit: &str, value: &dyn Fn(&DriveStep) -> f64| {
        Plot::over_time(title, until_s, unit, curves(value))
    };
    Gallery {
        heading: format!("Figure {number}: {name}"),
        plots: vec![
            plot("Gap", "m", &|step| step.gap_m.filter(|gap| *gap <= 150.0).unwrap_or(f64::NAN)),
            plot("Speed", "m/s", &|step| step.speed_mps),
            plot("Acceleration", "m/s²", &|step| step.acceleration_mps2),
            plot("Throttle opening, inverse model", "%", &|step| {
                pedals(step.speed_mps, step.acceleration_mps2).throttle_percent
            }),
            plot("Brake pressure, inverse model", "MPa", &|step| {
                pedals(step.speed_mps, step.acceleration_mps2).pressure_mpa
            }),
        ],
    }
}
