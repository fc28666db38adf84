//! The columns of a string's results.

use report::figures::{MAX_ABS_JERK_MPS3, MIN_GAP_M};
use report::print::outcome_word;
use report::results::{Column, Schema, Table, count, flag, judged, number, value, word};
use serde_json::json;
use supervise::report::Outcome;

use super::STABLE_GAIN;
use super::limits::{Limits, Point};
use super::results::{Results, Vehicle};
use super::wave::Response;

/// Most cars that a terminal shows.
const MOST_CARS: usize = 16;

const CARS: &[Column<Vehicle>] = &[
    count("index", "car", "Place in the string, from 1"),
    word("controller", "law", "Control law"),
    number("speed_gain_l2", "speed L2", "", 3, "Norm of its speed over that of the vehicle ahead")
        .limit(STABLE_GAIN),
    number("speed_gain_max", "speed max", "", 3, "The same of the largest deviations")
        .limit(STABLE_GAIN)
        .weight(2),
    number(
        "gap_error_gain_l2",
        "gap error L2",
        "",
        3,
        "Norm of its gap error over that of the car before",
    )
    .limit(STABLE_GAIN)
    .weight(1),
    number("gap_error_gain_max", "gap error max", "", 3, "The same of the largest errors")
        .limit(STABLE_GAIN)
        .weight(2),
    MIN_GAP_M.column(),
    MAX_ABS_JERK_MPS3.column(),
    judged("", "outcome", "How the drive ended").of(|car| {
        let after = if car.behind_collision { ", behind a collision" } else { "" };
        let text = format!("{}{after}", outcome_word(car.outcome));
        json!({"text": text, "ok": car.outcome == Outcome::Completed})
    }),
    word("", "requirements", "Margins of the requirements")
        .of(|car| json!(report::verdicts::words(&car.requirements))),
];

const CURVE: &[Column<Response>] = &[
    number("hz", "frequency", "Hz", 4, "Frequency of the lead's sine"),
    number("gain", "gain", "", 3, "Largest gain from one car to the next").limit(STABLE_GAIN),
    number("head_to_tail_gain", "head to tail", "", 3, "Gain from the lead to the last car"),
];

/// Columns of the values of a swept key.
const POINTS: &[Column<Point>] = &[
    value("value", "", "Value of the key"),
    number("peak_gain", "peak gain", "", 3, "Largest gain at any frequency").limit(STABLE_GAIN),
    number("peak_hz", "at", "Hz", 4, "Frequency of the largest gain"),
    flag("string_stable", "", ("stable", "unstable"), "No frequency is amplified"),
];

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Results>("string")
}

pub fn cars(results: &Results) -> Table {
    Table::new("Cars", CARS, &results.vehicles).most_rows(MOST_CARS)
}

pub fn curve(results: &Results) -> Table {
    Table::new("Behind a sine of the lead's speed", CURVE, &results.frequencies).without_cases()
}

/// A law over the values of a key.
pub fn limit(limits: &Limits) -> Table {
    let mut columns = POINTS.to_vec();
    columns[0].head.heading = limits.key.clone().into();
    Table::new(&limits.controller, &columns, &limits.points).without_cases()
}
