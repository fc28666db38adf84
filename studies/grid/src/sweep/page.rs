//! The figures of a sweep as curves over the swept key, and the result with them.

use super::results::{Folded, Sweep};
use crate::row::interventions;
use report::chart::{Axis, Curve, Plot, Tone};
use report::figures::{Figure, compared};
use report::html::{figure, grid};
use report::results::Document;
use report::summary::braked;

/// Most curves of a picture.
const MAX_CURVES: usize = 8;

/// The result for every output.
pub fn document(sweep: &Sweep) -> Document {
    let (whole, all) =
        (sweep.points.iter().map(|point| point.completed).sum::<usize>(), sweep.runs.len());
    let helped = braked(interventions(&sweep.runs));
    let curves: String = plots(sweep).iter().map(figure).collect();
    Document::new("sweep", &format!("Sweep of {}", sweep.scenario), sweep)
        .about(sweep.about())
        .verdict(sweep.ok, format!("{whole} of {all} runs without {}; {helped}", sweep.rules()))
        .figures("Figures", grid(&curves))
        .table(sweep.table())
        .text(sweep.reasons())
}

/// The figures over the first key whose values are numbers, a curve for each combination of the
/// others.
pub fn plots(sweep: &Sweep) -> Vec<Plot> {
    let numbers = |place: &usize| {
        let value = |point: &Folded| point.values[*place].parse::<f64>().ok();
        sweep.points.iter().map(value).collect::<Option<Vec<f64>>>()
    };
    let Some((place, values)) =
        (0..sweep.params.len()).find_map(|place| numbers(&place).map(|values| (place, values)))
    else {
        return Vec::new();
    };
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low >= high {
        return Vec::new();
    }
    let mut series: Vec<(String, Vec<(f64, &Folded)>)> = Vec::new();
    for (point, x) in sweep.points.iter().zip(values) {
        let others = sweep.params.iter().zip(&point.values).enumerate();
        let others = others.filter(|(index, _)| *index != place);
        let name: Vec<_> = others.map(|(_, (key, value))| in_words(key, value)).collect();
        let name = name.join(", ");
        match series.iter_mut().find(|(known, _)| *known == name) {
            Some((_, points)) => points.push((x, point)),
            None => series.push((name, vec![(x, point)])),
        }
    }
    series.truncate(MAX_CURVES);
    let mut plots: Vec<Plot> = Vec::new();
    let all: Vec<&Figure> = compared().collect();
    for panel in all.chunk_by(|a, b| a.panel == b.panel) {
        let mut curves: Vec<Curve> = Vec::new();
        for figure in panel {
            for (name, points) in &series {
                let at = |(x, p): &(f64, &Folded)| Some((*x, p.figures[figure.name].as_f64()?));
                let points: Vec<_> = points.iter().filter_map(at).collect();
                if !points.is_empty() {
                    // A panel of one figure says it in its title.
                    let label = match (panel.len(), name.is_empty()) {
                        (1, false) => name.clone(),
                        (_, true) => figure.heading.to_owned(),
                        (_, false) => format!("{}, {name}", figure.heading),
                    };
                    curves.push(Curve::new(&label, Tone::Series(curves.len()), points));
                }
            }
        }
        let (title, unit) = (panel[0].panel, panel[0].unit);
        if !curves.is_empty() {
            let x = Axis::linear(&axis(&sweep.params[place]), low, high);
            let plot = Plot::over(title, x, unit, curves);
            let values = plot.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
            let y = if unit.is_empty() { Axis::counts("number", values) } else { plot.y.clone() };
            plots.push(Plot { y, ..plot });
        }
    }
    plots
}

/// Suffixes of keys, and the units that they stand for; longer ones before those that end them.
const UNITS: [(&str, &str); 14] = [
    ("_per_m2", "1/m²"),
    ("_mps2", "m/s²"),
    ("_mps3", "m/s³"),
    ("_percent", "%"),
    ("_mps", "m/s"),
    ("_kmh", "km/h"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_us", "µs"),
    ("_ms", "ms"),
    ("_s", "s"),
    ("_m", "m"),
];

/// The name of a key in words, and its unit if the key has one.
fn name(key: &str) -> (String, Option<&'static str>) {
    let last = key.rsplit('.').next().unwrap_or(key);
    let unit = UNITS.iter().find_map(|(suffix, unit)| Some((last.strip_suffix(suffix)?, *unit)));
    let (words, unit) = unit.map_or((last, None), |(words, unit)| (words, Some(unit)));
    // A last part without a meaning of its own stands with the one before it: `controller.name`.
    let words = match key.rsplit('.').nth(1) {
        Some(before) if matches!(words, "name" | "vehicle" | "model" | "kind") => {
            format!("{before} {words}")
        }
        _ => words.to_owned(),
    };
    (words.replace('_', " "), unit)
}

/// A key at an axis: its name and unit, then the key itself.
fn axis(key: &str) -> String {
    match name(key) {
        (words, Some(unit)) => format!("{words}, {unit} ({key})"),
        (words, None) => format!("{words} ({key})"),
    }
}

fn in_words(key: &str, value: &str) -> String {
    match name(key) {
        (words, Some(unit)) => format!("{words} {value} {unit}"),
        // The value of a name is a name.
        (words, None) if words.ends_with(" name") => value.to_owned(),
        (words, None) => format!("{words} {value}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_become_words_with_units() {
        assert_eq!(axis("runtime.extra_delay_ms"), "extra delay, ms (runtime.extra_delay_ms)");
        assert_eq!(in_words("plant.mass_factor", "1.15"), "mass factor 1.15");
        assert_eq!(in_words("set_speed_mps", "25"), "set speed 25 m/s");
        assert_eq!(in_words("v2x.preview.noise_percent", "0.25"), "noise 0.25 %");
        assert_eq!(in_words("controller.name", "acc-mpc"), "acc-mpc");
        assert_eq!(axis("controller.weights.q1"), "q1 (controller.weights.q1)");
    }
}
