//! The result of a string with its pictures: positions and speeds of the cars, their gains, the limits.

use report::chart::{Axis, Chart, Curve, Plot, Stroke, Tone};
use report::html::{Tile, figure, grid};
use report::print::counted;
use report::results::Document;
use report::table::NONE;

use super::limits::Limits;
use super::results::{self, Results, Vehicle};
use super::wave::Driven;

/// Height of the time-space diagram, px.
const SPACE_HEIGHT: f64 = 360.0;
/// Most cars whose gain curves are drawn one by one.
const MAX_CURVES: usize = 6;

/// The result for every output.
pub fn document(results: &Results, driven: &[Driven]) -> Document {
    let until_s =
        driven.iter().flat_map(|car| &car.trace).map(|point| point[0]).fold(1.0, f64::max);
    let motion = figure(&time_space(driven, until_s)) + &figure(ribbons(driven, until_s));
    let laws = results.controllers.join(", ");
    let (count, scenario) = (counted(results.vehicles.len() as u64, "car"), &results.scenario);
    let whole = results.vehicles.iter().all(Vehicle::reached_the_end);
    let mut document = Document::new("string", &format!("String of {count}: {scenario}"), results)
        .about(format!("{scenario} ({laws}): {count}, {} s", results.duration_s))
        .verdict(results.string_stable && whole, results.verdict())
        // An unstable string is an answer, not a failure.
        .succeeds(whole && results.meets_requirements())
        .tiles(figures_of(results))
        .figures("Motion", grid(&motion))
        .table(results::cars(results));
    if driven.len() > 1 {
        document =
            document.figures("Amplification along the string", grid(&figure(&along(results))));
    }
    if !results.frequencies.is_empty() {
        let curve = grid(&figure(&gain_curve(results)));
        document = document.table(results::curve(results).figures("", curve));
    }
    if !results.limits.is_empty() {
        document = document.figures("Limits", grid(&limit_plots(&results.limits)));
    }
    for limits in &results.limits {
        document = document.text(limits.sentence() + ".").table(results::limit(limits));
    }
    document
}

fn figures_of(results: &Results) -> Vec<Tile> {
    let tile = |label, value, note: &str| Tile { label, value, note: note.to_owned() };
    let peak = results.peak.map(|peak| {
        let note = format!("at {:.4} Hz", peak.hz);
        tile("peak gain", format!("{:.3}", peak.gain), &note)
    });
    let jerks = results.vehicles.iter().filter_map(|vehicle| vehicle.max_abs_jerk_mps3);
    let text = |value: Option<f64>, decimals| {
        value.map_or_else(|| NONE.to_owned(), |value| report::chart::number(value, decimals))
    };
    let jerk = text(jerks.reduce(f64::max), 2);
    let head_to_tail = text(results.head_to_tail_gain, 3);
    [
        tile("head-to-tail gain", head_to_tail, "speed, L2"),
        tile("smallest gap", format!("{} m", text(results.min_gap_m, 2)), ""),
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

fn ribbons(cars: &[Driven], until_s: f64) -> Chart {
    let row = |car: &Driven| {
        car.trace.iter().map(|[time_s, _, speed_mps]| (*time_s, *speed_mps)).collect()
    };
    let rows: Vec<Vec<(f64, f64)>> = cars.iter().map(row).collect();
    report::chart::ribbons("Speeds of all cars", &Axis::time(until_s), "car", "m/s", &rows)
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

/// The peak of each law over the swept key; nothing for values that are not numbers.
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
