//! The columns of a comparison.

use super::differences::Difference;
use super::means::Means;
use super::row::Row;
use crate::figure::{ALL, Figure};
use report::results::{
    Column, Format, Kind, Schema, Table, count, fact, judged, micros, nested, number, outcome, word,
};
use serde_json::{Value, json};

/// Fields beside the rows.
const FIELDS: &[Column<()>] = &[
    frame::ok("Every run reached its end without a collision or a red light"),
    word("rule", "", "When a difference is called real; null for one seed"),
];

/// Columns of the runs.
const ROWS: &[Column<Row>] = &[
    word("scenario", "scenario", "Scenario that was driven"),
    word("controller", "law", "Control law that drove"),
    outcome("outcome"),
    count("seed", "seed", "Seed of the run").hidden(),
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
        .of(|row| json!(row.control.trip.over_fastest_s())),
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
    word("", "requirements", "Margins of the requirements")
        .of(|row| json!(report::verdicts::words(&row.requirements))),
];

/// The rest of a row, which programs see.
const NESTED: &[Column<Row>] = &[
    word("mode", "", "Clock of the run"),
    nested("control", Kind::Object, "Figures of the drive, as in summary.json"),
    nested("timing", Kind::Object, "Latencies and deadlines, as in summary.json"),
    nested("requirements", Kind::List, "Verdicts on the requirements, as in summary.json"),
    nested("law", Kind::Object, "Cycles by who commanded, as in summary.json"),
    nested("aebs", Kind::Object, "Interventions of the emergency brake, as in summary.json"),
];

/// Columns of a law in a scenario, over its seeds.
const OF_SEEDS: &[Column<Means>] = &[
    word("scenario", "scenario", "Scenario that was driven"),
    word("controller", "law", "Control law that drove"),
    count("runs", "", "Runs, one a seed"),
    count("completed", "", "Runs that reached the scenario's end"),
];

/// Columns of the differences from the first law.
const DIFFERENCES: &[Column<Difference>] = &[
    word("scenario", "scenario", "Scenario that was driven"),
    word("controller", "law", "Control law that drove"),
    word("reference", "", "The first law, from which the difference is taken").hidden(),
    word("figure", "", "Name of the figure: a key of `means.figures`, or `completed`").hidden(),
    word("", "figure", "").of(|difference| json!(difference.title)),
    number("mean", "difference", "", 3, "Mean of the differences over the seeds"),
    number("low", "from", "", 3, "Lower end of its interval; null of too few seeds").weight(1),
    number("high", "to", "", 3, "Upper end of its interval; null of too few seeds").weight(1),
    count("n", "n", "Pairs of runs").weight(2),
    fact("real", "", "The interval leaves out 0; null of too few seeds").hidden(),
    fact("better", "", "The law is better than the first one; null where that is open").hidden(),
    word("", "law is", "").of(|difference| json!(difference.verdict())),
];

/// The runs as a table with a block for each scenario.
pub fn runs(rows: &[Row]) -> Table {
    Table::new("Runs", ROWS, rows).blocks("scenario")
}

/// The runs of several seeds, whose seeds belong to their names.
pub fn runs_with_seeds(rows: &[Row]) -> Table {
    let mut columns = ROWS.to_vec();
    let place = columns.iter().position(|column| column.head.name == "seed");
    let mut seed = columns.remove(place.expect("it is one of them"));
    seed.head.is_hidden = false;
    columns.insert(2, seed);
    Table::new("Runs", &columns, rows)
}

/// The means as a table with a block for each scenario.
pub fn means(means: &[Means]) -> Table {
    let figures = ALL.iter().map(|figure| {
        let mut column = figure.column.clone();
        column.head.format = Format::Mean(2);
        column
    });
    let names: [Column<Value>; 3] = [
        word("scenario", "scenario", ""),
        word("controller", "law", ""),
        judged("ended", "outcome", "How the runs ended"),
    ];
    let columns: Vec<_> = names.into_iter().chain(figures).collect();
    let rows: Vec<Value> = means.iter().map(Means::shown).collect();
    Table::new("Means", &columns, &rows).blocks("scenario").without_cases()
}

/// The real differences for a terminal, and all of them for pages.
pub fn differences(all: &[Difference]) -> Vec<Table> {
    let Some(reference) = all.first().map(|difference| &difference.reference) else {
        return Vec::new();
    };
    let real: Vec<&Difference> = all.iter().filter(|difference| difference.is_real()).collect();
    let real = Table::of(&format!("Real differences from {reference}"), DIFFERENCES, real);
    let all = Table::new(&format!("All differences from {reference}"), DIFFERENCES, all);
    vec![real.for_terminals().without_cases(), all.for_pages().without_cases()]
}

/// Contents of the JSON.
pub fn schema() -> Schema {
    let columns = [NESTED, ROWS].concat();
    // A figure is in the JSON of every run; what is nested below `timing` may be null as a whole.
    let columns: Vec<_> =
        columns.into_iter().filter(|column| !column.head.name.starts_with("timing.")).collect();
    let spread = |figure: &Figure| {
        let head = &figure.column.head;
        let at = |what: &str| format!("figures.{}.{what}", figure.name());
        [
            number("", "", head.unit, 2, head.meaning).named(at("mean"), String::new()),
            number("", "", head.unit, 2, "Standard deviation over the seeds")
                .named(at("deviation"), String::new()),
            count("", "", "Seeds in which the figure applies").named(at("n"), String::new()),
        ]
    };
    let means: Vec<Column<Means>> =
        OF_SEEDS.iter().cloned().chain(ALL.iter().flat_map(spread)).collect();
    Schema::new("compare", "Laws side by side on the same scenarios")
        .fields(FIELDS)
        .rows("rows", "A row for each scenario, law and seed", &columns)
        .rows("means", "A row for each scenario and law, over its seeds", &means)
        .rows("differences", "Figures of each law minus those of the first one", DIFFERENCES)
}
