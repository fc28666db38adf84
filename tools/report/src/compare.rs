//! Several runs of one scenario in one picture.

use super::chart::{Curve, Picture, Plot, Stroke, Tone};
use super::html::figure;
use super::picture::{Points, RunPicture};

/// Speed, gap and acceleration of named runs over each other, with the vehicle ahead of the first.
pub fn overlay(runs: &[(&str, &RunPicture)]) -> String {
    let until_s = runs.iter().map(|(_, run)| run.duration_s).fold(0.0, f64::max);
    let curves = |series: fn(&RunPicture) -> &Points| -> Vec<Curve> {
        let runs = runs.iter().enumerate();
        runs.map(|(index, (name, run))| {
            Curve::new(name, Tone::Series(index), series(run).clone()).stroke(stroke(index))
        })
        .collect()
    };
    let mut speeds = curves(|run| &run.speed_mps);
    if let Some((name, run)) = runs.first() {
        let label = format!("vehicle ahead of {name}");
        speeds.push(
            Curve::new(&label, Tone::Muted, run.lead_speed_mps.clone()).stroke(Stroke::Dotted),
        );
    }
    let plots = [
        Plot::over_time("Speed", until_s, "m/s", speeds),
        Plot::over_time("Gap to the vehicle ahead", until_s, "m", curves(|run| &run.gap_m)),
        Plot::over_time("Acceleration", until_s, "m/s²", curves(|run| &run.acceleration_mps2)),
        Plot::over_time("Way", until_s, "m", curves(|run| &run.position_m)),
    ];
    let drawn: String =
        plots.iter().filter(|plot| !plot.keys().is_empty()).map(|plot| figure(plot)).collect();
    format!("<div class=\"grid\">\n{drawn}</div>\n")
}

/// The second round of colours has another stroke.
const fn stroke(index: usize) -> Stroke {
    if index.is_multiple_of(2) { Stroke::Solid } else { Stroke::Dashed }
}
