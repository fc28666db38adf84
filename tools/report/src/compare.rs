//! Several runs of one scenario in one picture.

use super::chart::{Curve, Plot, Stroke, Tone, escape};
use super::html::{figure, grid};
use super::picture::{Points, RunPicture};

/// Largest difference of two runs' speeds at which one curve covers the other, m/s.
const ALIKE_MPS: f64 = 0.01;

/// Speed, gap and acceleration of named runs in one picture, with the vehicle ahead of the first. A run that
/// drives like an earlier one is drawn below it and wider, so that both show.
pub fn overlay(runs: &[(&str, &RunPicture)]) -> String {
    let until_s = runs.iter().map(|(_, run)| run.duration_s).fold(0.0, f64::max);
    let curves = |series: fn(&RunPicture) -> &Points| -> Vec<Curve> {
        let curve = |(index, (name, run)): (usize, &(&str, &RunPicture))| {
            let curve = Curve::new(name, Tone::Series(index), series(run).clone());
            curve.covered_by(covers(runs, index))
        };
        runs.iter().enumerate().map(curve).collect()
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
        Plot::over_time("Position", until_s, "m", curves(|run| &run.position_m)),
    ];
    let drawn: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(figure).collect();
    grid(&drawn) + &alike(runs)
}

/// The first earlier run that drives like the one at `index`.
fn twin<'a>(runs: &[(&'a str, &RunPicture)], index: usize) -> Option<&'a str> {
    let (_, run) = runs[index];
    let same = |(_, other): &&(&str, &RunPicture)| {
        let mut pairs = run.speed_mps.iter().zip(&other.speed_mps);
        run.speed_mps.len() == other.speed_mps.len()
            && !run.speed_mps.is_empty()
            && pairs.all(|(a, b)| (a.1 - b.1).abs() <= ALIKE_MPS)
    };
    runs[..index].iter().find(same).map(|(name, _)| *name)
}

/// Number of earlier runs that cover the curves of the one at `index`.
fn covers(runs: &[(&str, &RunPicture)], index: usize) -> usize {
    match twin(runs, index) {
        Some(first) => 1 + (1..index).filter(|&earlier| twin(runs, earlier) == Some(first)).count(),
        None => 0,
    }
}

/// A line for each run that drives like an earlier one.
fn alike(runs: &[(&str, &RunPicture)]) -> String {
    let line = |(index, (name, _)): (usize, &(&str, &RunPicture))| {
        let (name, other) = (escape(name), escape(twin(runs, index)?));
        Some(format!(
            "<p class=\"quiet\">{name} drives like {other}, within {ALIKE_MPS} m/s: its curves are \
             the wider ones below.</p>\n"
        ))
    };
    runs.iter().enumerate().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_under_another_is_wider_and_named() {
        let run = |speed: f64| RunPicture {
            duration_s: 1.0,
            speed_mps: vec![(0.0, speed), (1.0, speed + 1.0)],
            ..RunPicture::default()
        };
        let (a, b, c) = (run(10.0), run(10.0), run(12.0));
        let drawn = overlay(&[("acc-mpc", &a), ("cacc-mpc", &b), ("other", &c)]);
        assert!(drawn.contains("cacc-mpc drives like acc-mpc"), "{drawn}");
        assert!(!drawn.contains("other drives like"), "{drawn}");
        assert_eq!(drawn.matches("\"width\":6.0").count(), 1, "{drawn}");
    }
}
