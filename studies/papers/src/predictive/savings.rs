//! The saving table: fuel on the given road at equal trip time.

use super::Trip;
use super::computed::{self, Baseline};
use super::headline;
use super::pictures;
use crate::Pictures;
use crate::row::{Kind, Row, Tolerance, reconstruction, requirement, within};
use crate::runner::{Driven, Part, Piece, Runner};
use group::Error;
use scenario::grade::GradeProfile;
use truck_model::Preset;

/// Drives of one planner until it takes the baseline's trip time.
const MAX_ATTEMPTS: usize = 3;
/// Largest difference of trip times that counts as none, percent.
const EQUAL_TIME_PERCENT: f64 = 0.1;

/// Fuel that the reconstruction gives for a preset: the baseline in L/100 km, then percent against it.
struct Reconstructed {
    preset: Preset,
    constant_speed: f64,
    paper_n2: f64,
    dynamic_programming: f64,
    full_route: f64,
    human_sigma_2_5: f64,
    human_sigma_4: f64,
}

const RECONSTRUCTED: [Reconstructed; 2] = [
    Reconstructed {
        preset: Preset::Jh6At49T,
        constant_speed: 34.25,
        paper_n2: -5.05,
        dynamic_programming: -7.6,
        full_route: -7.8,
        human_sigma_2_5: 1.6,
        human_sigma_4: 2.8,
    },
    Reconstructed {
        preset: Preset::Jh6At25T,
        constant_speed: 21.81,
        paper_n2: -2.15,
        dynamic_programming: -3.3,
        full_route: -3.4,
        human_sigma_2_5: 2.1,
        human_sigma_4: 3.6,
    },
];

/// Planners against the reconstruction's, percentage points.
const PLAN_POINTS: Tolerance = within(
    0.3,
    "another implementation of a planner on a grid; the n = 2 scheme is given as a range 0.1 to 0.3 wide",
);
/// Two plans of the same truck and road, percentage points.
const ROUTE_POINTS: Tolerance =
    within(0.3, "two kilometres ahead should cost no more; the grids of both plans err by less");
/// Human driver models, percentage points.
const HUMAN_POINTS: Tolerance =
    within(1.0, "means over a few seeds of a random driver whose slowdowns are not specified");
/// Trip times, percent.
const SAME_TIME: Tolerance =
    within(EQUAL_TIME_PERCENT, "0.1 % of trip time is worth about 0.1 % of fuel");

/// Errors of the robustness table: name, and the keys that cause it.
const WRONG: [(&str, &[&str]); 4] = [
    ("mass_15_percent_more", &["plant.mass_factor=1.15"]),
    ("mass_15_percent_less", &["plant.mass_factor=0.85"]),
    ("map_shifted_60_m", &["v2x.preview.shift_m=60"]),
    ("grade_noise_0.25_percent", &["v2x.preview.noise_percent=0.25"]),
];

/// A piece for each truck on the given road, on generated roads, and for each error of the robustness table.
pub fn pieces() -> Vec<Piece> {
    let on_the_road = RECONSTRUCTED
        .iter()
        .map(|expected| Piece::new(expected.preset.name(), |runner| preset(runner, expected)));
    let on_generated = RECONSTRUCTED.iter().map(|expected| {
        let name = format!("{} on generated roads", expected.preset.name());
        Piece::new(name, |_| Ok(Part::of_rows(vec![generated(expected.preset)])))
    });
    let wrong = WRONG.into_iter().map(|(what, keys)| {
        Piece::new(what, move |runner| Ok(Part::of_rows(vec![robustness(runner, what, keys)?])))
    });
    on_the_road.chain(on_generated).chain(wrong).collect()
}

/// The rows of one preset on the given road.
fn preset(runner: &Runner<'_>, expected: &Reconstructed) -> Result<Part, Error> {
    let preset = expected.preset;
    let (baseline, constant) = constant_speed(runner, preset, &[])?;
    let name = |what: &str| format!("{}.{what}", preset.name());
    let litres = baseline.map(|trip| trip.corrected_l_per_100km);
    let one_percent =
        within(0.01 * expected.constant_speed, "1 %: the road's heights are known within 3 %");
    let mut rows = vec![
        Row::near(
            &name("constant_speed_l_per_100km"),
            "L",
            reconstruction(expected.constant_speed),
            litres,
            one_percent,
        )
        .with_note("driven; the baseline of the rows below"),
    ];
    let planners =
        [("paper-n2", expected.paper_n2), ("dynamic-programming", expected.dynamic_programming)];
    let mut of_planners = Vec::new();
    for (planner, value) in planners {
        let (trip, driven) = at_equal_time(runner, preset, planner, &[], baseline)?;
        let change = trip.zip(baseline).map(|(trip, baseline)| trip.against(&baseline));
        rows.push(
            Row::near(&name(planner), "%", reconstruction(value), change, PLAN_POINTS)
                .with_note("driven; fuel against constant speed"),
        );
        rows.extend(conditions(&name(planner), trip, baseline));
        of_planners.push((planner, change, driven));
    }
    let change = of_planners.last().and_then(|(_, change, _)| *change);
    let road = constant.scenario.road.profile().unwrap_or_default();
    let (of_model, driver_percent) = computed(runner, expected, &road, change);
    rows.extend(of_model);
    for (planner, _, driven) in &of_planners {
        let name = format!("{}.{planner}.service_brake_s", preset.name());
        let braked_s = driven.summary.control.figures.service_brake_s;
        rows.push(
            Row::shown(&name, "s", Kind::Paper, braked_s, "driven; the paper's truck has none")
                .with_source("it controls neither throttle nor brakes, but engine torque directly"),
        );
    }
    for (planner, change, _) in &of_planners {
        let set = format!("{}, {planner}", preset.name());
        rows.extend(headline::rows(&set, litres, *change, driver_percent));
    }
    let trips: Vec<(&'static str, &Driven)> = std::iter::once(("constant speed", &constant))
        .chain(of_planners.iter().map(|(planner, _, driven)| (*planner, driven)))
        .collect();
    // The pictures show the drives, over distance.
    let galleries = vec![pictures::trips(preset, &trips)];
    Ok(Part { rows, pictures: Pictures { galleries, drives: Vec::new() } })
}

/// The trip at constant speed.
fn constant_speed(
    runner: &Runner<'_>,
    preset: Preset,
    wrong: &[&str],
) -> Result<(Option<Trip>, Driven), Error> {
    let driven = drive(runner, preset, "constant-speed", 1.0, wrong)?;
    Ok((Trip::of(preset, &driven.drive.steps), driven))
}

/// Drives at mean speeds that approach the baseline's trip time; the last trip.
fn at_equal_time(
    runner: &Runner<'_>,
    preset: Preset,
    planner: &str,
    wrong: &[&str],
    baseline: Option<Trip>,
) -> Result<(Option<Trip>, Driven), Error> {
    let mut mean_speed = 1.0;
    let mut attempt = 1;
    loop {
        let driven = drive(runner, preset, planner, mean_speed, wrong)?;
        let trip = Trip::of(preset, &driven.drive.steps);
        let Some((trip, baseline)) = trip.zip(baseline) else { return Ok((trip, driven)) };
        let slower_percent = trip.slower_than(&baseline);
        if slower_percent.abs() <= 0.5 * EQUAL_TIME_PERCENT || attempt == MAX_ATTEMPTS {
            return Ok((Some(trip), driven));
        }
        // The law servoes the mean speed: trip time goes about as one over it.
        mean_speed *= 1.0 + slower_percent / 100.0;
        attempt += 1;
    }
}

fn drive(
    runner: &Runner<'_>,
    preset: Preset,
    planner: &str,
    mean_speed: f64,
    wrong: &[&str],
) -> Result<Driven, Error> {
    let mut keys = vec![
        format!("plant.vehicle=\"{}\"", preset.name()),
        format!("controller.predictive.planner=\"{planner}\""),
        format!("controller.predictive.mean_speed={mean_speed}"),
        "duration_s=2960".to_owned(),
    ];
    keys.extend(wrong.iter().map(ToString::to_string));
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    runner.drive("truck-hills", &keys)
}

/// Conditions of a fair comparison.
fn conditions(name: &str, trip: Option<Trip>, baseline: Option<Trip>) -> Vec<Row> {
    let slower = trip.zip(baseline).map(|(trip, baseline)| trip.slower_than(&baseline).abs());
    let correction = trip.map(|trip| trip.correction_l_per_100km);
    vec![
        Row::near(&format!("{name}.trip_time"), "%", requirement(0.0), slower, SAME_TIME)
            .with_note("difference of trip times"),
        Row::shown(
            &format!("{name}.end_energy_correction"),
            "L",
            Kind::Requirement,
            correction,
            "per 100 km, in the figure above",
        ),
    ]
}

/// The full-route plan and the human driver models, computed on the same truck and road. The fuel of the calmer driver
/// is against constant speed, percent.
fn computed(
    runner: &Runner<'_>,
    expected: &Reconstructed,
    road: &GradeProfile,
    driven: Option<f64>,
) -> (Vec<Row>, Option<f64>) {
    const AGAINST: &str = "computed; fuel against constant speed, computed alike";
    let preset = expected.preset;
    let name = |what: &str| format!("{}.{what}", preset.name());
    let baseline = Baseline::drive(preset, road);
    let route = baseline.as_ref().and_then(Baseline::full_route_percent);
    let human = baseline
        .as_ref()
        .map_or([None; 3], |baseline| baseline.human_percent(runner.driver_spread_mps()));
    let above = driven.zip(route).map(|(driven, route)| driven - route);
    let litres = baseline.as_ref().map(Baseline::litres);
    let [calm, restless] = [expected.human_sigma_2_5, expected.human_sigma_4].map(reconstruction);
    let rows = vec![
        Row::shown(
            &name("constant_speed_computed_l_per_100km"),
            "L",
            Kind::Reconstruction,
            litres,
            "computed",
        ),
        Row::near(
            &name("full_route"),
            "%",
            reconstruction(expected.full_route),
            route,
            PLAN_POINTS,
        )
        .with_note("computed; the full-route plan against constant speed, computed alike"),
        Row::near(
            &name("dynamic-programming.above_full_route"),
            "%",
            requirement(0.0),
            above,
            ROUTE_POINTS,
        )
        .with_note("driven less the computed full-route plan, percentage points"),
        Row::near(&name("human_sigma_2.5"), "%", calm, human[0], HUMAN_POINTS).with_note(AGAINST),
        Row::near(&name("human_sigma_4"), "%", restless, human[1], HUMAN_POINTS).with_note(AGAINST),
    ];
    (rows, human[2])
}

/// Distance of the planner from the full-route plan on roads of other seeds: the largest one, on either side.
fn generated(preset: Preset) -> Row {
    let above = (1..=computed::GENERATED).map(|seed| {
        let baseline = Baseline::drive(preset, &computed::generated(seed))?;
        Some(baseline.planned_percent()? - baseline.full_route_percent()?)
    });
    let above = above.collect::<Option<Vec<f64>>>();
    let farthest = above.and_then(|all| all.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())));
    let id = format!("{}.dynamic-programming.above_full_route_generated", preset.name());
    Row::near(&id, "%", requirement(0.0), farthest, ROUTE_POINTS)
        .with_note("computed; the farthest of ten generated roads, percentage points")
}

/// Rest of the saving when the law's truck or map is wrong.
fn robustness(runner: &Runner<'_>, what: &str, keys: &[&str]) -> Result<Row, Error> {
    let preset = RECONSTRUCTED[0].preset;
    // A wrong mass changes the baseline, a wrong map does not.
    let of_truck = if what.starts_with("mass") { keys } else { &[] };
    let (baseline, _) = constant_speed(runner, preset, of_truck)?;
    let (trip, _) = at_equal_time(runner, preset, "dynamic-programming", keys, baseline)?;
    // Unequal trip times are not compared.
    let equal = trip
        .zip(baseline)
        .filter(|(trip, baseline)| trip.slower_than(baseline).abs() <= EQUAL_TIME_PERCENT);
    let change = equal.map(|(trip, baseline)| trip.against(&baseline));
    Ok(Row::shown(
        &format!("{}.{what}", preset.name()),
        "%",
        Kind::Requirement,
        change,
        "driven; dynamic-programming against constant speed of the same truck",
    ))
}
