//! The results for people.

use std::fmt::Write;

use report::print::outcome_word;
use report::table::{Align, NONE, TextTable};

use super::results::{Results, Vehicle};

/// Most cars that a terminal shows; of more, the first and the last.
const MAX_ROWS: usize = 16;
/// Cars shown at the end of such a string.
const LAST_ROWS: usize = 4;

/// The results as text: the cars, the gain curve, the limits, a verdict.
pub fn text(results: &Results) -> String {
    let mut text = String::new();
    let line = |text: &mut String, words: std::fmt::Arguments<'_>| {
        writeln!(text, "{words}").expect("a string takes all");
    };
    let laws = results.controllers.join(", ");
    let count = cars(results.vehicles.len());
    let (scenario, duration_s) = (&results.scenario, results.duration_s);
    line(&mut text, format_args!("{scenario} ({laws}): {count}, {duration_s} s"));
    text += &vehicles(&results.vehicles);
    if !results.frequencies.is_empty() {
        let head = ["frequency, Hz", "gain", "head to tail"];
        let mut table = TextTable::new(head.map(|name| (name, Align::Right)));
        for response in &results.frequencies {
            let hz = format!("{:.4}", response.hz);
            table.row([hz, gain(response.gain), gain(response.head_to_tail_gain)]);
        }
        line(&mut text, format_args!("behind a sine of the lead's speed"));
        text += &table.text();
    }
    for limits in &results.limits {
        line(&mut text, format_args!("{}", limits.sentence()));
        let head = [limits.key.as_str(), "peak gain", "at, Hz", ""];
        let mut table = TextTable::new(head.map(|name| (name, Align::Right)));
        for point in &limits.points {
            let hz = point.peak_hz.map_or_else(|| NONE.into(), |hz| format!("{hz:.4}"));
            let word = if point.string_stable { "stable" } else { "unstable" };
            table.row([point.value.0.clone(), gain(point.peak_gain), hz, word.into()]);
        }
        text += &table.text();
    }
    line(&mut text, format_args!("{}", verdict(results)));
    text
}

/// The string in a sentence.
pub fn verdict(results: &Results) -> String {
    let is_measured =
        results.peak.is_some() || results.vehicles.iter().any(|car| car.speed_gain_l2.is_some());
    let stable = match results.string_stable {
        true if is_measured => "string stable",
        true => "string stable, with no disturbance to amplify",
        false => "NOT string stable",
    };
    let peak = results.peak.map_or_else(String::new, |peak| {
        format!(", peak gain {:.3} at {:.4} Hz", peak.gain, peak.hz)
    });
    let collisions = results.vehicles.iter().filter(|vehicle| is_collision(vehicle)).count();
    let collisions = match collisions {
        0 => String::new(),
        count => format!(", {} collided", cars(count)),
    };
    let head_to_tail = results
        .head_to_tail_gain
        .map_or_else(String::new, |gain| format!(", head-to-tail gain {gain:.3}"));
    format!("{stable}{peak}{head_to_tail}{collisions}")
}

/// So many cars.
pub fn cars(count: usize) -> String {
    if count == 1 { "1 car".to_owned() } else { format!("{count} cars") }
}

fn is_collision(vehicle: &Vehicle) -> bool {
    vehicle.outcome == runtime::report::Outcome::Collision
}

fn vehicles(all: &[Vehicle]) -> String {
    let numbers = [
        "speed L2",
        "speed max",
        "gap error L2",
        "gap error max",
        "least gap, m",
        "max jerk, m/s³",
    ];
    let head = [("car", Align::Right), ("law", Align::Left)];
    let head = head.into_iter().chain(numbers.map(|name| (name, Align::Right)));
    let mut table = TextTable::new(head.chain([("outcome", Align::Left)]));
    let left_out = if all.len() > MAX_ROWS { all.len() - MAX_ROWS } else { 0 };
    let first = if left_out > 0 { MAX_ROWS - LAST_ROWS } else { all.len() };
    for (place, vehicle) in all.iter().enumerate() {
        if left_out > 0 && place == first {
            table.row(["...".to_owned(), format!("{left_out} more")]);
        }
        if place >= first && place < first + left_out {
            continue;
        }
        let after = if vehicle.behind_collision { ", behind a collision" } else { "" };
        let outcome = format!("{}{after}", outcome_word(vehicle.outcome));
        table.row([
            vehicle.index.to_string(),
            vehicle.controller.clone(),
            gain(vehicle.speed_gain_l2),
            gain(vehicle.speed_gain_max),
            gain(vehicle.gap_error_gain_l2),
            gain(vehicle.gap_error_gain_max),
            figure(vehicle.min_gap_m),
            figure(vehicle.max_abs_jerk_mps3),
            outcome,
        ]);
    }
    table.text()
}

/// A gain, or a dash where there is none.
pub fn gain(gain: Option<f64>) -> String {
    gain.map_or_else(|| NONE.into(), |gain| format!("{gain:.3}"))
}

/// A figure, or a dash where it does not apply.
pub fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.into(), |value| format!("{value:.2}"))
}
