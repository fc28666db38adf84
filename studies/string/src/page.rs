//! The page of a string: where the cars were and how fast, their gains, the limits.

use report::chart::{Axis, Curve, Plot, Ribbon, Ribbons, Stroke, Tone};
use report::html::{Cell, Column, Tile, document, figure, section, table, tiles};
use report::print::outcome_word;
use runtime::report::Outcome;

use super::STABLE_GAIN;
use super::drive::Driven;
use super::limits::Limits;
use super::print::{self, verdict};
use super::results::Results;

/// Height of the time-space diagram, px.
const SPACE_HEIGHT: f64 = 360.0;
/// Most cars whose gain curves are drawn one by one.
const MAX_CURVES: usize = 6;

/// The page.
pub fn page(results: &Results, cars: &[Driven]) -> String {
    let mut body = tiles(&figures_of(results));
    let until_s = cars.iter().flat_map(|car| &car.trace).map(|point| point[0]).fold(1.0, f64::max);
    let motion = figure(&time_space(cars, until_s)) + &figure(&ribbons(cars, until_s));
    body += &section("Motion", &grid(&motion));
    if cars.len() > 1 {
        body += &section("Amplification along the string", &grid(&figure(&along(results))));
    }
    if !results.frequencies.is_empty() {
        body += &section("Behind a sine", &grid(&figure(&gain_curve(results))));
    }
    if !results.limits.is_empty() {
        body += &section("Limits", &(grid(&limit_plots(&results.limits)) + &limits(results)));
    }
    body += &section("Cars", &vehicles(results));
    document(
        &format!("String of {}: {}", print::cars(results.vehicles.len()), results.scenario),
        &results.controllers.join(", "),
        results.string_stable && results.all_completed(),
        &verdict(results),
        &body,
    )
}

fn grid(figures: &str) -> String {
    format!("<div class=\"grid\">\n{figures}</div>\n")
}

fn figures_of(results: &Results) -> Vec<Tile> {
    let tile = |label, value, note: &str| Tile { label, value, note: note.to_owned() };
    let peak = results.peak.map(|peak| {
        let note = format!("at {:.4} Hz", peak.hz);
        tile("peak gain", format!("{:.3}", peak.gain), &note)
    });
    let jerks = results.vehicles.iter().filter_map(|vehicle| vehicle.max_abs_jerk_mps3);
    let jerk = print::figure(jerks.reduce(f64::max));
    let head_to_tail = print::gain(results.head_to_tail_gain);
    [
        tile("head-to-tail gain", head_to_tail, "speed, L2"),
        tile("least gap", format!("{} m", print::figure(results.min_gap_m)), ""),
        tile("largest jerk", format!("{jerk} m/s³"), ""),
    ]
    .into_iter()
    .chain(peak)
    .collect()
}

/// Colour of a law: the same in all pictures.
fn tone(laws: &[&str], law: &str) -> Tone {
    Tone::Series(laws.iter().position(|known| *known == law).unwrap_or(0))
}

/// The laws of a string, each once.
fn laws(cars: &[Driven]) -> Vec<&str> {
    let mut laws: Vec<&str> = Vec::new();
    for car in cars {
        if !laws.contains(&car.controller.as_str()) {
            laws.push(&car.controller);
        }
    }
    laws
}

fn time_space(cars: &[Driven], until_s: f64) -> Plot {
    let laws = laws(cars);
    let curves = cars.iter().map(|car| {
        let points = car.trace.iter().map(|[time_s, position_m, _]| (*time_s, *position_m));
        Curve::new(&car.controller, tone(&laws, &car.controller), points.collect()).thin()
    });
    let plot = Plot::over_time("Positions of all cars", until_s, "position, m", curves.collect());
    Plot { height: SPACE_HEIGHT, ..plot }
}

fn ribbons(cars: &[Driven], until_s: f64) -> Ribbons {
    let rows = cars.iter().map(|car| Ribbon {
        values: car.trace.iter().map(|[time_s, _, speed_mps]| (*time_s, *speed_mps)).collect(),
    });
    Ribbons {
        title: "Speeds of all cars".into(),
        x: Axis::time(until_s),
        rows_label: "car".into(),
        unit: "m/s".into(),
        rows: rows.collect(),
    }
}

fn along(results: &Results) -> Plot {
    let curve = |name: &str, index, figure: fn(&super::results::Vehicle) -> Option<f64>| {
        let vehicles = results.vehicles.iter();
        let points = vehicles.filter_map(|car| Some((car.index as f64, figure(car)?)));
        Curve::new(name, Tone::Series(index), points.collect())
    };
    let count = results.vehicles.len() as f64;
    let limit = Curve::new("no amplification", Tone::Muted, vec![(1.0, 1.0), (count, 1.0)]);
    let curves = vec![
        curve("speed, L2", 0, |car| car.speed_gain_l2),
        curve("speed, largest", 1, |car| car.speed_gain_max),
        curve("gap error, L2", 2, |car| car.gap_error_gain_l2),
        limit.stroke(Stroke::Dotted),
    ];
    // There is no car 0; six at least, so that no tick stands between two cars.
    Plot::over("Gain from car to car", Axis::linear("car", 1.0, count.max(6.0)), "gain", curves)
}

fn gain_curve(results: &Results) -> Plot {
    let all = &results.frequencies;
    let (low, high) = (all[0].hz, all[all.len() - 1].hz);
    let count = results.vehicles.len();
    let mut curves = Vec::new();
    if count <= MAX_CURVES && count > 1 {
        for car in 0..count {
            let points = all.iter().filter_map(|at| Some((at.hz, at.gains[car]?)));
            let vehicle = &results.vehicles[car];
            let name = format!("car {} ({})", car + 1, vehicle.controller);
            curves.push(Curve::new(&name, Tone::Series(car), points.collect()));
        }
    } else {
        let points = all.iter().filter_map(|at| Some((at.hz, at.gain?)));
        curves.push(Curve::new("car to car, largest", Tone::Series(0), points.collect()));
    }
    if count > 1 {
        let points = all.iter().filter_map(|at| Some((at.hz, at.head_to_tail_gain?)));
        let curve = Curve::new("head to tail", Tone::Series(MAX_CURVES), points.collect());
        curves.push(curve.stroke(Stroke::Dashed));
    }
    curves.push(one(low, high));
    Plot::over("Gain over frequency", Axis::frequencies("Hz", low, high), "gain", curves)
}

fn one(low: f64, high: f64) -> Curve {
    let name = "no amplification";
    Curve::new(name, Tone::Muted, vec![(low, 1.0), (high, 1.0)]).stroke(Stroke::Dotted)
}

/// The peak of each law over the swept key; nothing for values that are no numbers.
fn limit_plots(limits: &[Limits]) -> String {
    let mut curves = Vec::new();
    let mut values = Vec::new();
    for (index, limits) in limits.iter().enumerate() {
        let points = limits.points.iter();
        let points = points.filter_map(|point| Some((point.value.number()?, point.peak_gain?)));
        let points: Vec<_> = points.collect();
        values.extend(points.iter().map(|point| point.0));
        curves.push(Curve::new(&limits.controller, Tone::Series(index), points));
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if low >= high {
        return String::new();
    }
    curves.push(one(low, high));
    let x = Axis::linear(&limits[0].key, low, high);
    figure(&Plot::over("Peak of the gain", x, "gain", curves))
}

fn limits(results: &Results) -> String {
    let head = [
        ("law", Column::Text),
        (results.limits[0].key.as_str(), Column::Number),
        ("peak gain", Column::Number),
        ("at, Hz", Column::Number),
        ("", Column::Text),
    ];
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for limits in &results.limits {
        for point in &limits.points {
            let hz = point.peak_hz.map_or_else(|| "–".to_owned(), |hz| format!("{hz:.4}"));
            let word = match point.string_stable {
                true => Cell::Good("stable".into()),
                false => Cell::Bad("unstable".into()),
            };
            rows.push(vec![
                limits.controller.clone().into(),
                point.value.0.clone().into(),
                print::gain(point.peak_gain).into(),
                hz.into(),
                word,
            ]);
        }
    }
    let sentences = results.limits.iter().map(|limits| {
        let sentence = report::chart::escape(&limits.sentence());
        format!("<p>{sentence}.</p>\n")
    });
    sentences.collect::<String>() + &table(&head, &rows)
}

fn vehicles(results: &Results) -> String {
    let head = [
        ("car", Column::Number),
        ("law", Column::Text),
        ("speed, L2", Column::Number),
        ("speed, largest", Column::MoreNumber),
        ("gap error, L2", Column::MoreNumber),
        ("gap error, largest", Column::MoreNumber),
        ("least gap, m", Column::Number),
        ("largest jerk, m/s³", Column::MoreNumber),
        ("outcome", Column::Text),
    ];
    let gain = |value: Option<f64>| -> Cell {
        let text = print::gain(value);
        if value.is_some_and(|gain| gain > STABLE_GAIN) { Cell::Bad(text) } else { text.into() }
    };
    let rows = results.vehicles.iter().map(|car| {
        let after = if car.behind_collision { ", behind a collision" } else { "" };
        let outcome = format!("{}{after}", outcome_word(car.outcome));
        let outcome = match car.outcome {
            Outcome::Completed => outcome.into(),
            _ => Cell::Bad(outcome),
        };
        vec![
            car.index.to_string().into(),
            car.controller.clone().into(),
            gain(car.speed_gain_l2),
            gain(car.speed_gain_max),
            gain(car.gap_error_gain_l2),
            gain(car.gap_error_gain_max),
            print::figure(car.min_gap_m).into(),
            print::figure(car.max_abs_jerk_mps3).into(),
            outcome,
        ]
    });
    table(&head, &rows.collect::<Vec<_>>())
}
