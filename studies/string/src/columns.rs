//! The columns of a string's results.

use group::report::Outcome;
use report::print::outcome_word;
use report::results::{
    Column, Kind, Schema, Table, count, fact, flag, judged, nested, number, outcome, value, word,
};
use serde_json::json;

use super::STABLE_GAIN;
use super::limits::{Limits, Point};
use super::response::Response;
use super::results::{Results, Vehicle};

/// Most cars that a terminal shows.
const MOST_CARS: usize = 16;

/// Fields beside the lists.
const FIELDS: &[Column<Results>] = &[
    word("scenario", "", "Scenario of the first car"),
    nested("controllers", Kind::List, "Laws, in the order in which they repeat along the string"),
    count("seed", "", "Seed of the first car"),
    number("duration_s", "", "s", 1, "Length of the scenario"),
    number(
        "head_to_tail_gain",
        "",
        "",
        3,
        "Norm of the last car's speed over that of the vehicle ahead of the first",
    ),
    number("head_to_tail_gain_max", "", "", 3, "The same of the largest deviations"),
    number("min_gap_m", "", "m", 2, "Smallest gap of all cars"),
    flag("string_stable", "", ("stable", "unstable"), "No car amplifies the disturbance"),
    nested("stability", Kind::Object, "Verdict on string-stable; null where it is not required"),
    nested("peak", Kind::Object, "Highest point of the gain curve"),
];

/// Columns of the cars.
const CARS: &[Column<Vehicle>] = &[
    count("index", "car", "Place in the string, from 1"),
    word("controller", "law", "Control law"),
    outcome("outcome").hidden(),
    nested("requirements", Kind::List, "Verdicts on the requirements, as in summary.json"),
    fact("behind_collision", "", "A car ahead of it collided").hidden(),
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
    number("min_gap_m", "min gap", "m", 2, "Smallest gap to the vehicle ahead"),
    number("max_abs_gap_error_m", "", "m", 2, "Largest gap error").hidden(),
    number("max_abs_jerk_mps3", "max jerk", "m/s³", 2, "Largest magnitude of the jerk").weight(1),
    number("rms_jerk_mps3", "", "m/s³", 2, "Root mean square of the jerk").hidden(),
    judged("", "outcome", "How the drive ended").of(|car| {
        let after = if car.behind_collision { ", behind a collision" } else { "" };
        let text = format!("{}{after}", outcome_word(car.outcome));
        json!({"text": text, "ok": car.outcome == Outcome::Completed})
    }),
    word("", "requirements", "Margins of the requirements")
        .of(|car| json!(report::verdicts::words(&car.requirements))),
];

/// Columns of the gain curve.
const CURVE: &[Column<Response>] = &[
    number("hz", "frequency", "Hz", 4, "Frequency of the lead's sine"),
    number("gain", "gain", "", 3, "Largest gain from one car to the next").limit(STABLE_GAIN),
    number("head_to_tail_gain", "head to tail", "", 3, "Gain from the lead to the last car"),
    nested("gains", Kind::List, "Gain of each car"),
];

/// Columns of a law's limit, for programs.
const LIMITS: &[Column<Limits>] = &[
    word("controller", "", "Control law"),
    word("key", "", "Swept key"),
    value("stable", "", "Stable value of the first two neighbours that differ in stability"),
    value("unstable", "", "Unstable value of these two"),
    number("ceases_at", "", "", 4, "Value at which the peak of the gain passes the limit"),
    nested("points", Kind::List, "The values of the key"),
];

/// Columns of the values of a swept key.
const POINTS: &[Column<Point>] = &[
    value("value", "", "Value of the key"),
    number("peak_gain", "peak gain", "", 3, "Largest gain at any frequency").limit(STABLE_GAIN),
    number("peak_hz", "at", "Hz", 4, "Frequency of the largest gain"),
    flag("string_stable", "", ("stable", "unstable"), "No frequency is amplified"),
    nested("frequencies", Kind::List, "The gain curve"),
];

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::new("string", "A string of cars")
        .fields(FIELDS)
        .rows("vehicles", "The cars, first to last", CARS)
        .rows("frequencies", "The string behind a sine of each frequency", CURVE)
        .rows("limits", "Limits of string stability of each law", LIMITS)
        .rows("limits.points", "A row for each value of the key", POINTS)
        .rows("limits.points.frequencies", "The gain curve", CURVE)
}

/// The cars.
pub fn cars(results: &Results) -> Table {
    Table::new("Cars", CARS, &results.vehicles).most_rows(MOST_CARS)
}

/// The gain curve.
pub fn curve(results: &Results) -> Table {
    Table::new("Behind a sine of the lead's speed", CURVE, &results.frequencies).without_cases()
}

/// A law over the values of a key.
pub fn limit(limits: &Limits) -> Table {
    let mut columns = POINTS.to_vec();
    columns[0].head.heading = limits.key.clone().into();
    Table::new(&limits.controller, &columns, &limits.points).without_cases()
}
