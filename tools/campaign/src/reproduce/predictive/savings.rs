//! The saving table: fuel on the given road at equal trip time.

use super::Trip;
use super::computed::{self, Baseline};
use super::pictures;
use crate::reproduce::row::Row;
use crate::reproduce::{Driven, Runner};
use group::Error;
use scenario::grade::GradeProfile;
use truck_model::Preset;

/// Drives of one planner until its trip time is that of the baseline.
pub const MAX_ATTEMPTS: usize = 3;
/// Largest difference of trip times that counts as none, percent.
const EQUAL_TIME_PERCENT: f64 = 0.1;

/// What the page says of a preset: fuel of the baseline in L/100 km, then fuel against it in percent.
struct Published {
    preset: Preset,
    constant_speed: f64,
    paper_n2: f64,
    dynamic_programming: f64,
    bound: f64,
    human_sigma_2_5: f64,
    human_sigma_4: f64,
}

const PUBLISHED: [Published; 2] = [
    Published {
        preset: Preset::Jh6At49T,
        constant_speed: 34.25,
        paper_n2: -4.9,
        dynamic_programming: -7.6,
        bound: -7.8,
        human_sigma_2_5: 1.6,
        human_sigma_4: 2.8,
    },
    Published {
        preset: Preset::Jh6At25T,
        constant_speed: 21.81,
        paper_n2: -2.1,
        dynamic_programming: -3.3,
        bound: -3.4,
        human_sigma_2_5: 2.1,
        human_sigma_4: 3.6,
    },
];

/// What is wrong in the robustness table: its name and the keys that make it so.
const WRONG: [(&str, &[&str]); 4] = [
    ("mass_15_percent_more", &["plant.mass_factor=1.15"]),
    ("mass_15_percent_less", &["plant.mass_factor=0.85"]),
    ("map_shifted_60_m", &["v2x.preview.shift_m=60"]),
    ("grade_noise_0.25_percent", &["v2x.preview.noise_percent=0.25"]),
];
/// Drives of the robustness table, at most.
pub const ROBUSTNESS_RUNS: usize = WRONG.len() * (1 + MAX_ATTEMPTS);

pub fn reproduce(runner: &mut Runner<'_>, rows: &mut Vec<Row>) -> Result<(), Error> {
    let mut baselines = Vec::new();
    for published in &PUBLISHED {
        let preset = published.preset;
        let (baseline, constant) = constant_speed(runner, preset, &[])?;
        baselines.push(baseline);
        let name = |what: &str| format!("{}.{what}", preset.name());
        let fuel = baseline.map(|trip| trip.corrected_l_per_100km);
        rows.push(
            Row::near(
                &name("constant_speed_l_per_100km"),
                "L",
                published.constant_speed,
                fuel,
                0.01 * published.constant_speed,
            )
            .with_note("driven; the baseline of the rows below"),
        );
        let mut of_planners = Vec::new();
        for (planner, paper, tolerance) in [
            // The page gives one decimal place.
            ("paper-n2", published.paper_n2, 0.05),
            ("dynamic-programming", published.dynamic_programming, 0.3),
        ] {
            let (trip, driven) = at_equal_time(runner, preset, planner, &[], baseline.as_ref())?;
            let change = trip.zip(baseline).map(|(trip, baseline)| trip.against(&baseline));
            rows.push(
                Row::at_most(&name(planner), "%", paper, change, tolerance)
                    .with_note("driven; fuel against constant speed, at most the page's"),
            );
            rows.extend(conditions(&name(planner), trip, baseline));
            of_planners.push((planner, change, driven));
        }
        let change = of_planners.last().and_then(|(_, change, _)| *change);
        let road = constant.scenario.road.profile().unwrap_or_default();
        rows.extend(bounded(runner, published, &road, change));
        rows.push(generated(runner, preset));
        let driven: Vec<(&'static str, &Driven)> = std::iter::once(("constant speed", &constant))
            .chain(of_planners.iter().map(|(planner, _, driven)| (*planner, driven)))
            .collect();
        runner.pictures.push(pictures::trips(preset, &driven));
    }
    robustness(runner, baselines[0], rows)
}

/// The trip at constant speed.
fn constant_speed(
    runner: &mut Runner<'_>,
    preset: Preset,
    wrong: &[&str],
) -> Result<(Option<Trip>, Driven), Error> {
    let driven = drive(runner, preset, "constant-speed", 1.0, wrong)?;
    Ok((Trip::of(preset, &driven.drive.steps), driven))
}

/// Drives at mean speeds that approach the baseline's trip time; the last trip.
fn at_equal_time(
    runner: &mut Runner<'_>,
    preset: Preset,
    planner: &str,
    wrong: &[&str],
    baseline: Option<&Trip>,
) -> Result<(Option<Trip>, Driven), Error> {
    let mut mean_speed = 1.0;
    let mut attempt = 1;
    loop {
        let driven = drive(runner, preset, planner, mean_speed, wrong)?;
        let trip = Trip::of(preset, &driven.drive.steps);
        let Some((trip, baseline)) = trip.zip(baseline.copied()) else { return Ok((trip, driven)) };
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
    runner: &mut Runner<'_>,
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

/// What makes a comparison fair.
fn conditions(name: &str, trip: Option<Trip>, baseline: Option<Trip>) -> Vec<Row> {
    let slower = trip.zip(baseline).map(|(trip, baseline)| trip.slower_than(&baseline).abs());
    let correction = trip.map(|trip| trip.correction_l_per_100km);
    vec![
        Row::at_most(&format!("{name}.trip_time"), "%", 0.0, slower, EQUAL_TIME_PERCENT)
            .with_note("difference of trip times"),
        Row::shown(
            &format!("{name}.end_energy_correction"),
            "L",
            correction,
            "per 100 km, in the figure above",
        ),
    ]
}

/// The bound and the drivers of flesh and blood, computed on the same truck and road.
fn bounded(
    runner: &Runner<'_>,
    published: &Published,
    road: &GradeProfile,
    driven: Option<f64>,
) -> Vec<Row> {
    const AGAINST: &str = "computed; fuel against constant speed, computed alike";
    let preset = published.preset;
    let name = |what: &str| format!("{}.{what}", preset.name());
    let baseline = Baseline::drive(preset, road);
    let bound = baseline.as_ref().and_then(Baseline::bound_percent);
    runner.bar.tick();
    let human = baseline.as_ref().map_or([None; 2], Baseline::human_percent);
    runner.bar.tick();
    let above = driven.zip(bound).map(|(driven, bound)| driven - bound);
    let litres = baseline.as_ref().map(Baseline::litres);
    let [calm, restless] = [published.human_sigma_2_5, published.human_sigma_4];
    vec![
        Row::shown(&name("constant_speed_computed_l_per_100km"), "L", litres, "computed"),
        Row::near(&name("full_route"), "%", published.bound, bound, 0.3).with_note(AGAINST),
        Row::at_most(&name("dynamic-programming.above_full_route"), "%", 0.0, above, 0.3)
            .with_note("driven less computed, percentage points"),
        Row::near(&name("human_sigma_2.5"), "%", calm, human[0], 1.0).with_note(AGAINST),
        Row::near(&name("human_sigma_4"), "%", restless, human[1], 1.0).with_note(AGAINST),
    ]
}

/// How far the planner stays from the bound on roads of other seeds: the worst of them.
fn generated(runner: &Runner<'_>, preset: Preset) -> Row {
    let above = (1..=computed::GENERATED).map(|seed| {
        runner.bar.tick();
        let baseline = Baseline::drive(preset, &computed::generated(seed))?;
        Some(baseline.planned_percent()? - baseline.bound_percent()?)
    });
    let worst = above.collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max));
    let id = format!("{}.dynamic-programming.above_full_route_generated", preset.name());
    Row::at_most(&id, "%", 0.0, worst, 0.3)
        .with_note("computed; the worst of ten generated roads, percentage points")
}

/// What is left of the saving when the law's truck or map is wrong.
fn robustness(
    runner: &mut Runner<'_>,
    right: Option<Trip>,
    rows: &mut Vec<Row>,
) -> Result<(), Error> {
    let preset = PUBLISHED[0].preset;
    for (what, keys) in WRONG {
        // A wrong mass changes the baseline, a wrong map does not.
        let baseline =
            if what.starts_with("mass") { constant_speed(runner, preset, keys)?.0 } else { right };
        let (trip, _) =
            at_equal_time(runner, preset, "dynamic-programming", keys, baseline.as_ref())?;
        // Unequal trip times are not compared.
        let equal = trip
            .zip(baseline)
            .filter(|(trip, baseline)| trip.slower_than(baseline).abs() <= EQUAL_TIME_PERCENT);
        let change = equal.map(|(trip, baseline)| trip.against(&baseline));
        rows.push(Row::shown(
            &format!("{}.{what}", preset.name()),
            "%",
            change,
            "driven; dynamic-programming against constant speed of the same truck",
        ));
    }
    Ok(())
}
