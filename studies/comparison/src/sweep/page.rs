//! The page of a sweep: the figures as curves over the swept key, and the table of all points.

use super::figure::ALL;
use super::results::{Point, Sweep};
use super::words;
use report::chart::{Axis, Curve, Plot, Tone};
use report::html::{Cell, Column, document, figure, section, table};
use report::summary::braked;
use runtime::report::Outcome;

/// Most curves that a picture tells apart.
const MAX_CURVES: usize = 8;

/// The page.
pub fn page(sweep: &Sweep) -> String {
    let whole = sweep.runs.iter().filter(|run| run.outcome == Outcome::Completed).count();
    let helped = braked(sweep.interventions());
    let verdict = format!(
        "{whole} of {} runs without a collision or a red light; {helped}",
        sweep.runs.len()
    );
    let plots = plots(sweep);
    let curves: String = plots.iter().map(|plot| figure(plot)).collect();
    let curves = if curves.is_empty() {
        curves
    } else {
        section("Figures", &format!("<div class=\"grid\">\n{curves}</div>\n"))
    };
    document(
        &format!("Sweep of {}", sweep.scenario),
        &format!(
            "{} · {} · over {}",
            sweep.controllers.join(", "),
            sweep.mode,
            sweep.params.join(", ")
        ),
        whole == sweep.runs.len(),
        &verdict,
        &(curves + &section("Points", &points(sweep))),
    )
}

/// The figures over the first key whose values are numbers, a curve for each combination of the
/// others.
pub fn plots(sweep: &Sweep) -> Vec<Plot> {
    let numbers = |place: &usize| {
        let value = |point: &Point| point.values[*place].parse::<f64>().ok();
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
    let mut series: Vec<(String, Vec<(f64, &Point)>)> = Vec::new();
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
    for panel in ALL.chunk_by(|a, b| a.panel == b.panel) {
        let mut curves: Vec<Curve> = Vec::new();
        for figure in panel {
            let index = ALL.iter().position(|other| other.name == figure.name).expect("of these");
            for (name, points) in &series {
                let points = points.iter();
                let points = points.filter_map(|(x, p)| Some((*x, p.figures.0[index]?)));
                let points: Vec<_> = points.collect();
                if !points.is_empty() {
                    // A panel of one figure says it in its title.
                    let label = match (panel.len(), name.is_empty()) {
                        (1, false) => name.clone(),
                        (_, true) => figure.label.to_owned(),
                        (_, false) => format!("{}, {name}", figure.label),
                    };
                    curves.push(Curve::new(&label, Tone::Series(curves.len()), points));
                }
            }
        }
        let (title, unit) = panel[0].panel.split_once(", ").unwrap_or((panel[0].panel, ""));
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

fn points(sweep: &Sweep) -> String {
    let shown: Vec<usize> = (0..ALL.len())
        .filter(|&index| sweep.points.iter().any(|point| point.figures.0[index].is_some()))
        .collect();
    let params = sweep.params.iter().map(|key| (key.as_str(), Column::Number));
    let figures = shown.iter().map(|&index| (ALL[index].heading, Column::Number));
    let head: Vec<_> = params.chain(figures).chain([("completed", Column::Number)]).collect();
    let row = |point: &Point| -> Vec<Cell> {
        let figures = shown.iter().map(|&index| {
            point.figures.0[index].map_or_else(|| "–".to_owned(), |value| format!("{value:.2}"))
        });
        let completed = format!("{} of {}", point.completed, point.seeds);
        let last = if point.completed == point.seeds {
            Cell::Plain(completed)
        } else {
            Cell::Bad(completed)
        };
        point.values.iter().cloned().chain(figures).map(Cell::Plain).chain([last]).collect()
    };
    table(&head, &sweep.points.iter().map(row).collect::<Vec<_>>())
}
