//! The saving table: fuel on the given road at equal trip time. Its headline is fuel and saving against a skilled
//! driver, for each truck and planner, with all brakes and with none.

use super::computed::{PLAN_POINTS, RECONSTRUCTED, Reconstructed, SKILLED, TEST};
use super::{ROAD_M, computed, litres, slower_percent, trip};
use crate::page::over_road;
use crate::row::{EXACT, Kind, Row, Tolerance, paper, reconstruction, requirement, within};
use crate::runner::{Driven, Gallery, Part, Pictures, Piece, Runner};
use crate::trips::Trip;
use scenario::Setting;
use supervise::Error;
use truck_model::Preset;

/// Drives of one planner until it takes the baseline's trip time.
const MAX_ATTEMPTS: usize = 3;
/// Largest difference of trip times that counts as none, percent.
const EQUAL_TIME_PERCENT: f64 = 0.1;
/// Trip times, percent.
const SAME_TIME: Tolerance =
    within(EQUAL_TIME_PERCENT, "0.1 % of trip time is worth about 0.1 % of fuel");
/// Fuel, L/100 km.
const WHOLE_LITRES: Tolerance = within(0.5, "\"about\", and printed in whole litres");
/// Saving on the paper's road, percent.
const ABOUT: Tolerance = within(
    1.1,
    "\"about\": the printed 20 and 22 L make 9.1 %, 1.1 points more than the printed 8 %",
);
/// Saving over all roads, percent.
const PRINTED_RANGE: Tolerance = within(1.0, "printed as the range 6 to 8 %");

/// The paper's sentences.
const STEPS: &str = "steps 4 to 6: rolling optimisation with n = 2, torque constant per segment";
const FEWER: &str = "figure 6: stretches of several slopes become one, fewer segments";
const NO_BRAKE: &str = "it controls neither throttle nor brakes, but engine torque directly";
const MAP: &str = "the slope ahead is the on-board map's; the truck is loaded to its full mass";
/// Assumptions behind the rows of the headline, which the paper does not print.
const ROAD_AND_TRUCK: &str =
    "road and truck: the heights of the motorway near Qingdao and table 1 are not printed";
const DRIVER: &str =
    "the skilled driver: the paper's are statistics of real trips, ours a model of 2.5 km/h spread";

/// Errors of the robustness table: name, and the key that causes it with its value.
const WRONG: [(&str, &str, f64); 4] = [
    ("mass_15_percent_more", "plant.mass_factor", 1.15),
    ("mass_15_percent_less", "plant.mass_factor", 0.85),
    ("map_shifted_60_m", "v2x.preview.shift_m", 60.0),
    ("grade_noise_0.25_percent", "v2x.preview.noise_percent", 0.25),
];
/// The planners: the paper's, and the law's default.
const PLANNERS: [&str; 2] = ["paper-n2", "dynamic-programming"];
/// Name of the paper's law, which has no brakes.
const WITHOUT_BRAKES: &str = ", brakes = none";

/// A piece for each truck on the given road, on generated roads, and for each error of the robustness table.
pub fn pieces() -> Vec<Piece> {
    let on_the_road = RECONSTRUCTED
        .iter()
        .map(|expected| Piece::new(expected.preset.name(), |runner| preset(runner, expected)));
    let on_generated = RECONSTRUCTED.iter().map(|expected| {
        let name = format!("{} on generated roads", expected.preset.name());
        Piece::new(name, |_| Ok(Part::of_rows(vec![computed::on_generated(expected.preset)])))
    });
    let wrong = WRONG.into_iter().map(|(what, key, value)| {
        Piece::new(what, move |runner| {
            let wrong = Setting::new(key, value);
            Ok(Part::of_rows(vec![robustness(runner, what, &[wrong])?]))
        })
    });
    on_the_road.chain(on_generated).chain(wrong).collect()
}

/// The rows of one preset on the given road.
fn preset(runner: &Runner<'_>, expected: &Reconstructed) -> Result<Part, Error> {
    let preset = expected.preset;
    let name = |what: &str| format!("{}.{what}", preset.name());
    let (baseline, constant) = constant_speed(runner, preset, &[])?;
    let baseline_l = baseline.as_ref().map(|trip| litres(preset, trip));
    let one_percent =
        within(0.01 * expected.constant_speed, "1 %: the road's heights are known within 3 %");
    let constant_id = name("constant_speed_l_per_100km");
    let expected_l = reconstruction(expected.constant_speed);
    let mut rows = vec![
        Row::near(&constant_id, "L", expected_l, baseline_l, one_percent)
            .with_source(TEST)
            .with_note("driven; the baseline of the rows below"),
    ];
    let mut driven = Vec::new();
    for (planner, percent) in PLANNERS.into_iter().zip(expected.planners) {
        let free = at_equal_time(runner, preset, planner, &[], baseline.as_ref())?;
        let change = free
            .0
            .as_ref()
            .zip(baseline.as_ref())
            .map(|(trip, baseline)| against_percent(preset, trip, baseline));
        rows.push(
            Row::near(&name(planner), "%", reconstruction(percent), change, PLAN_POINTS)
                .with_source(STEPS)
                .with_note("driven; fuel against constant speed"),
        );
        rows.extend(conditions(&name(planner), preset, free.0.as_ref(), baseline.as_ref()));
        let unbraked = [Setting::new("controller.predictive.brakes", "none")];
        let bare = at_equal_time(runner, preset, planner, &unbraked, baseline.as_ref())?;
        driven.push((planner, change, free, bare));
    }
    let change = driven.last().and_then(|(_, change, ..)| *change);
    let road = constant.scenario.road.profile().unwrap_or_default();
    let (of_model, driver_percent) = computed::rows(runner, expected, &road, change);
    rows.extend(of_model);
    rows.push(
        Row::at_most(
            &name("stretches_per_cell"),
            "",
            paper(1.0),
            computed::stretches(preset, &road),
            EXACT,
        )
        .with_source(FEWER)
        .with_note("stretches of the reconstruction over the cells of 50 m of the road"),
    );
    for (planner, _, free, bare) in &driven {
        for ((trip, driven), brakes) in [(free, ""), (bare, WITHOUT_BRAKES)] {
            let set = format!("{}, {planner}{brakes}", preset.name());
            let of_set = headline(preset, trip.as_ref(), baseline_l, driver_percent);
            let id = name(&format!("{planner}.service_brake_s"));
            let braked_s = driven.summary.control.figures.service_brake_s;
            let steps = driven.drive.steps.iter().map(|step| 3.6 * step.speed_mps);
            let of_brakes = [
                Row::near(&id, "s", paper(0.0), braked_s, EXACT).with_source(NO_BRAKE),
                Row::shown(
                    "headline.fastest_kmh",
                    "km/h",
                    Kind::Paper,
                    steps.reduce(f64::max),
                    "the paper draws it and prints no number",
                )
                .with_source("figure 7: the speed varies about the set speed of 75 km/h"),
            ];
            rows.extend(of_set.into_iter().chain(of_brakes).map(|row| row.in_set(&set)));
        }
    }
    let mut trips = vec![("constant speed", &constant)];
    trips.extend(driven.iter().map(|(planner, _, (_, driven), _)| (*planner, driven)));
    let plot = |title, unit, value: &dyn Fn(&Driven, &supervise::DriveStep) -> Option<f64>| {
        over_road(title, unit, ROAD_M, &trips, value)
    };
    let gallery = Gallery {
        heading: format!("{} at 75 km/h", preset.name()),
        plots: vec![
            plot("Speed (figure 7)", "km/h", &|_, step| Some(3.6 * step.speed_mps)),
            plot("Economic speed (figure 7)", "km/h", &|driven, step| {
                let names = &driven.figure_names;
                let index = names.iter().position(|name| *name == "economic_speed_mps")?;
                Some(3.6 * step.figures?[index])
            }),
            plot("Engine torque", "N m", &|_, step| Some(step.powertrain?.engine_torque_nm)),
        ],
    };
    Ok(Part { rows, pictures: Pictures { galleries: vec![gallery], drives: Vec::new() } })
}

fn against_percent(preset: Preset, trip: &Trip, baseline: &Trip) -> f64 {
    100.0 * (litres(preset, trip) / litres(preset, baseline) - 1.0)
}

fn constant_speed(
    runner: &Runner<'_>,
    preset: Preset,
    wrong: &[Setting],
) -> Result<(Option<Trip>, Driven), Error> {
    let driven = drive(runner, preset, "constant-speed", 1.0, wrong)?;
    Ok((trip(preset, &driven.drive.steps), driven))
}

/// Drives at mean speeds that approach the baseline's trip time; the last trip.
fn at_equal_time(
    runner: &Runner<'_>,
    preset: Preset,
    planner: &str,
    set: &[Setting],
    baseline: Option<&Trip>,
) -> Result<(Option<Trip>, Driven), Error> {
    let mut mean_speed = 1.0;
    let mut attempt = 1;
    loop {
        let driven = drive(runner, preset, planner, mean_speed, set)?;
        let trip = trip(preset, &driven.drive.steps);
        let slower =
            trip.as_ref().zip(baseline).map(|(trip, baseline)| slower_percent(trip, baseline));
        match slower {
            // The law servoes the mean speed: trip time goes about as one over it.
            Some(percent) if percent.abs() > 0.5 * EQUAL_TIME_PERCENT && attempt < MAX_ATTEMPTS => {
                mean_speed *= 1.0 + percent / 100.0;
            }
            _ => return Ok((trip, driven)),
        }
        attempt += 1;
    }
}

fn drive(
    runner: &Runner<'_>,
    preset: Preset,
    planner: &str,
    mean_speed: f64,
    set: &[Setting],
) -> Result<Driven, Error> {
    let of_truck = [
        Setting::new("plant.vehicle", preset.name()),
        Setting::new("controller.predictive.planner", planner),
        Setting::new("controller.predictive.mean_speed", mean_speed),
        Setting::new("duration_s", 2960),
    ];
    runner.drive("truck-hills", &[&of_truck, set].concat())
}

/// Conditions of a fair comparison.
fn conditions(
    name: &str,
    preset: Preset,
    trip: Option<&Trip>,
    baseline: Option<&Trip>,
) -> [Row; 2] {
    let slower = trip.zip(baseline).map(|(trip, baseline)| slower_percent(trip, baseline).abs());
    let correction_l = trip.map(|trip| litres(preset, trip) - trip.corrected_l_per_100_km(0.0));
    let id = |what: &str| format!("{name}.{what}");
    let note = "per 100 km, in the figure above";
    [
        Row::near(&id("trip_time"), "%", requirement(0.0), slower, SAME_TIME)
            .with_note("difference of trip times"),
        Row::shown(&id("end_energy_correction"), "L", Kind::Requirement, correction_l, note),
    ]
    .map(|row| row.with_source(TEST))
}

/// Fuel and saving of a trip against the skilled driver's. `driver_percent` is the driver's fuel against constant speed.
fn headline(
    preset: Preset,
    trip: Option<&Trip>,
    baseline_l: Option<f64>,
    driver_percent: Option<f64>,
) -> [Row; 4] {
    let ours_l = trip.map(|trip| litres(preset, trip));
    let driver_l =
        baseline_l.zip(driver_percent).map(|(litres, percent)| litres * (1.0 + percent / 100.0));
    let saving = ours_l.zip(driver_l).map(|(ours, driver)| 100.0 * (1.0 - ours / driver));
    let rows = [
        Row::near("headline.fuel_l_per_100km", "L", paper(20.0), ours_l, WHOLE_LITRES)
            .with_source("fuel per 100 km in this test is about 20 L")
            .depending_on(ROAD_AND_TRUCK),
        Row::near("headline.driver_l_per_100km", "L", paper(22.0), driver_l, WHOLE_LITRES)
            .with_source(SKILLED)
            .depending_on(DRIVER),
        Row::near("headline.saving", "%", paper(8.0), saving, ABOUT)
            .with_source("the predictive control saves about 8 %")
            .depending_on(DRIVER),
        Row::near("headline.saving_overall", "%", paper(7.0), saving, PRINTED_RANGE)
            .with_source("more than 1.3 million km; 6 to 8 % less than skilled drivers over all")
            .depending_on(DRIVER),
    ];
    rows.map(|row| row.with_note("at the trip time of constant speed"))
}

/// Rest of the saving when the law's truck or map is wrong.
fn robustness(runner: &Runner<'_>, what: &str, wrong: &[Setting]) -> Result<Row, Error> {
    let preset = RECONSTRUCTED[0].preset;
    // A wrong mass changes the baseline, a wrong map does not.
    let of_truck = if what.starts_with("mass") { wrong } else { &[] };
    let (baseline, _) = constant_speed(runner, preset, of_truck)?;
    let (trip, _) = at_equal_time(runner, preset, PLANNERS[1], wrong, baseline.as_ref())?;
    // Unequal trip times are not compared.
    let equal = trip
        .as_ref()
        .zip(baseline.as_ref())
        .filter(|(trip, baseline)| slower_percent(trip, baseline).abs() <= EQUAL_TIME_PERCENT);
    let change = equal.map(|(trip, baseline)| against_percent(preset, trip, baseline));
    let id = format!("{}.{what}", preset.name());
    let note = "driven; dynamic-programming against constant speed of the same truck";
    Ok(Row::shown(&id, "%", Kind::Requirement, change, note).with_source(MAP))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_saving_is_against_the_driver() {
        let preset = Preset::Jh6At25T;
        let fuel_g = 19.2 * truck_model::FUEL_DENSITY_GPL * ROAD_M / 1e5;
        let trip = Trip { length_m: ROAD_M, fuel_g, ..Trip::default() };
        let rows = headline(preset, Some(&trip), Some(20.0), Some(4.0));
        let ours = rows.map(|row| row.ours.expect("it is known"));
        let expected = [19.2, 20.8, 100.0 * (1.0 - 0.96 / 1.04), 100.0 * (1.0 - 0.96 / 1.04)];
        assert!(ours.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{ours:?}");
    }
}
