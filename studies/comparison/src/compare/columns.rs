//! The columns of a comparison.

use super::{Comparison, Row};
use report::results::{Column, Kind, Schema, Table, count, micros, nested, number, outcome, word};
use serde_json::json;

/// Fields beside the rows.
const FIELDS: &[Column<Comparison>] =
    &[frame::ok("Every run reached its end without a collision or a red light")];

/// Columns of the runs.
const ROWS: &[Column<Row>] = &[
    word("scenario", "scenario", "Scenario that was driven"),
    word("controller", "law", "Control law that drove"),
    outcome("outcome"),
    number("control.min_gap_m", "min gap", "m", 1, "Smallest gap to the vehicle ahead").more(),
    number(
        "control.min_time_gap_s",
        "min time gap",
        "s",
        2,
        "Smallest time gap to the vehicle ahead",
    )
    .more(),
    number("control.median_time_gap_s", "median time gap", "s", 2, "Median time gap").weight(2),
    number("control.impact_speed_mps", "impact", "m/s", 1, "Speed difference at the contact")
        .less()
        .weight(2),
    number("control.min_ttc_s", "min TTC", "s", 1, "Smallest time to collision").more(),
    count("aebs.interventions", "emergency brakings", "Interventions of the emergency brake")
        .less()
        .weight(1),
    number("", "trip over the fastest", "s", 1, "Trip time beyond the fastest legal trip")
        .less()
        .weight(3)
        .of(|row| {
            let trip = &row.control.trip;
            json!(
                trip.trip_time_s.zip(trip.fastest_legal_trip_s).map(|(own, fastest)| own - fastest)
            )
        }),
    number("control.rms_gap_error_m", "gap error rms", "m", 2, "Root mean square of the gap error")
        .less()
        .weight(1),
    number(
        "control.final_gap_error_m",
        "gap error at the end",
        "m",
        1,
        "Gap error at the end of the run",
    )
    .weight(5),
    number("control.min_accel_mps2", "hardest braking", "m/s²", 2, "Smallest acceleration")
        .more()
        .weight(1),
    number("control.max_accel_mps2", "max acceleration", "m/s²", 2, "Largest acceleration")
        .weight(4),
    number("control.rms_jerk_mps3", "jerk rms", "m/s³", 2, "Root mean square of the jerk")
        .less()
        .weight(1),
    number("control.max_abs_jerk_mps3", "max jerk", "m/s³", 1, "Largest magnitude of the jerk")
        .less()
        .weight(3),
    number("control.fuel_l_per_100km", "fuel", "L/100 km", 2, "Fuel").less().weight(2),
    word("", "energy", "Whether energy and fuel can be compared with other trips").weight(3).of(
        |row| match row.control.trip.energy_is_comparable {
            Some(false) => json!("not comparable: too short"),
            _ => json!(null),
        },
    ),
    count("", "cycles by backup", "Cycles that the backup of the law commanded")
        .less()
        .weight(2)
        .of(|row| json!(row.law.as_ref().map(|law| law.backup).filter(|backup| *backup > 0))),
    number("control.wheel_energy_kwh_per_100km", "wheels", "kWh/100 km", 2, "Energy at the wheels")
        .less()
        .weight(3),
    count("control.stops", "stops", "Times that the vehicle came to a stand").less().weight(3),
    micros("timing.solve_us.p50", "law p50", "Median time inside the law, µs").weight(4),
    micros("timing.solve_us.p99", "law p99", "99th percentile of the time inside the law, µs")
        .weight(4),
    count(
        "timing.deadline_misses",
        "deadlines missed",
        "Control cycles that ended late; null in lockstep",
    )
    .less(),
];

/// The rest of a row, which programs see.
const NESTED: &[Column<Row>] = &[
    word("mode", "", "Clock of the run"),
    nested("control", Kind::Object, "Figures of the drive, as in summary.json"),
    nested("timing", Kind::Object, "Latencies and deadlines, as in summary.json"),
    nested("law", Kind::Object, "Cycles by who commanded, as in summary.json"),
    nested("aebs", Kind::Object, "Interventions of the emergency brake, as in summary.json"),
];

/// The runs as a table with a block for each scenario.
pub fn table(rows: &[Row]) -> Table {
    Table::new("Runs", ROWS, rows).blocks("scenario")
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    let columns = [NESTED, ROWS].concat();
    // A figure is in the JSON of every run; what is nested below `timing` may be null as a whole.
    let columns: Vec<_> =
        columns.into_iter().filter(|column| !column.head.name.starts_with("timing.")).collect();
    frame::schema("compare", "Laws side by side on the same scenarios").fields(FIELDS).rows(
        "rows",
        "A row for each scenario and law",
        &columns,
    )
}
