//! Pictures of a paper, for its page.

use crate::driven::Driven;
use report::RunPicture;
use report::chart::{Axis, Curve, Plot, Stroke, Tone};
use supervise::DriveStep;

/// Pictures of a paper, for its page.
#[derive(Debug, Default)]
pub struct Pictures {
    /// Drives, by their names.
    pub drives: Vec<(String, RunPicture)>,
    /// The paper's own figures.
    pub galleries: Vec<Gallery>,
}

impl Pictures {
    /// Adds those of another piece.
    pub fn extend(&mut self, other: Self) {
        self.drives.extend(other.drives);
        self.galleries.extend(other.galleries);
    }
}

/// Plots below one heading.
#[derive(Debug)]
pub struct Gallery {
    pub heading: String,
    pub plots: Vec<Plot>,
}

/// One value of some drives over time.
pub fn over_time(
    title: &str,
    unit: &str,
    drives: &[(&str, &Driven)],
    value: &dyn Fn(&Driven) -> Vec<(f64, f64)>,
) -> Plot {
    let ends_s = drives.iter().map(|(_, driven)| driven.scenario.duration_s.value());
    over(title, Axis::time(ends_s.fold(0.0, f64::max)), unit, drives, value)
}

/// One value of some drives over the road to `until_m`.
pub fn over_road(
    title: &str,
    unit: &str,
    until_m: f64,
    drives: &[(&str, &Driven)],
    value: &dyn Fn(&Driven, &DriveStep) -> Option<f64>,
) -> Plot {
    let points = |driven: &Driven| {
        let steps = driven.drive.steps.iter().take_while(|step| step.position_m <= until_m);
        steps.filter_map(|step| Some((step.position_m / 1e3, value(driven, step)?))).collect()
    };
    over(title, Axis::linear("distance, km", 0.0, until_m / 1e3), unit, drives, &points)
}

fn over(
    title: &str,
    x: Axis,
    unit: &str,
    drives: &[(&str, &Driven)],
    points: &dyn Fn(&Driven) -> Vec<(f64, f64)>,
) -> Plot {
    let curve = |(index, (name, driven)): (usize, &(&str, &Driven))| {
        let stroke = if index == 0 { Stroke::Solid } else { Stroke::Dashed };
        Curve::new(name, Tone::Series(index), points(driven)).stroke(stroke)
    };
    Plot::over(title, x, unit, drives.iter().enumerate().map(curve).collect())
}
