//! The figures of a sweep as curves over the swept key, and the result with them.

use super::results::{Folded, Sweep};
use super::words;
use crate::row::interventions;
use report::chart::{Axis, Curve, Plot, Tone};
use report::figures::{Figure, compared};
use report::html::figure;
use report::results::Document;
use report::summary::braked;

/// Most curves of a picture.
const MAX_CURVES: usize = 8;

/// The result for every output.
pub fn document(sweep: &Sweep) -> Document {
    let (whole, all) =
        (sweep.points.iter().map(|point| point.completed).sum::<usize>(), sweep.runs.len());
    let helped = braked(interventions(&sweep.runs));
    let curves: String = plots(sweep).iter().map(|plot| figure(plot)).collect();
    let curves = match curves.as_str() {
        "" => curves,
        drawn => format!("<div class=\"grid\">\n{drawn}</div>\n"),
    };
    Document::new("sweep", &format!("Sweep of {}", sweep.scenario), sweep)
        .about(sweep.about())
        .verdict(sweep.ok, format!("{whole} of {all} runs without {}; {helped}", sweep.rules()))
        .figures("Figures", curves)
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
        let name: Vec<_> = others.map(|(_, (key, value))| words::value(key, value)).collect();
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
            let x = Axis::linear(&words::axis(&sweep.params[place]), low, high);
            let plot = Plot::over(title, x, unit, curves);
            let values = plot.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
            let y = if unit.is_empty() { Axis::counts("number", values) } else { plot.y.clone() };
            plots.push(Plot { y, ..plot });
        }
    }
    plots
}
