//! Figures computed without processes: the full-route plan, human driver models, generated roads.

use super::{ROAD_M, SET_SPEED_MPS};
use crate::row::{Kind, Row, Tolerance, reconstruction, requirement, within};
use crate::runner::Runner;
use crate::trips::{Comparison, Road, Trip, generated};
use controller::law::{MAX_CELLS, Preview};
use controller::laws::truck::{LimitGrades, PlannerKind, Reconstruction, RoadKeys};
use scenario::grade::GradeProfile;
use truck_model::{Preset, Truck};

/// Seeds over which a driver's fuel is averaged.
const HUMAN_SEEDS: u64 = 4;
/// Roads on which the planner is compared with the full-route plan.
const GENERATED: u64 = 10;
/// Length of a road's cells, m.
const CELL_M: f64 = 50.0;

/// Two plans of the same truck and road, percentage points.
const ROUTE_POINTS: Tolerance =
    within(0.3, "two kilometres ahead should cost no more; the grids of both plans err by less");
/// Human driver models, percentage points.
const HUMAN_POINTS: Tolerance =
    within(1.0, "means over a few seeds of a random driver whose slowdowns are not specified");
const HORIZON: &str = "step 1: the slope of the 2 km ahead is read";

/// The full-route plan and the human driver models, computed on the same truck and road. The fuel of the driver with
/// the chosen spread is against constant speed, percent.
pub fn rows(
    runner: &Runner<'_>,
    expected: &Reconstructed,
    road: &GradeProfile,
    driven: Option<f64>,
) -> ([Row; 5], Option<f64>) {
    const AGAINST: &str = "computed; fuel against constant speed, computed alike";
    let preset = expected.preset;
    let id = |what: &str| format!("{}.{what}", preset.name());
    let comparison =
        Comparison::new(&Truck::preset(preset), &Road::from_profile(road), SET_SPEED_MPS);
    let comparison = comparison.as_ref();
    let change = |trip: Option<Trip>| Some(comparison?.change_percent(&trip?));
    let human = |sigma_mps: f64| {
        let trips = (1..=HUMAN_SEEDS).map(|seed| change(comparison?.human(sigma_mps, seed)));
        let changes = trips.collect::<Option<Vec<f64>>>()?;
        Some(changes.iter().sum::<f64>() / changes.len() as f64)
    };
    let route = change(comparison.and_then(Comparison::bound));
    let above = driven.zip(route).map(|(driven, route)| driven - route);
    let litres = comparison.map(|comparison| comparison.l_per_100_km(&comparison.baseline));
    let (calm_mps, restless_mps) = (2.5 / 3.6, 4.0 / 3.6);
    let calm = human(calm_mps);
    let other_mps = runner.driver_spread_mps;
    let other = if other_mps == calm_mps { calm } else { human(other_mps) };
    let near =
        |what: &str, value, ours, by| Row::near(&id(what), "%", reconstruction(value), ours, by);
    let above_id = id("dynamic-programming.above_full_route");
    let litres_id = id("constant_speed_computed_l_per_100km");
    let rows = [
        Row::shown(&litres_id, "L", Kind::Reconstruction, litres, "computed").with_source(TEST),
        near("full_route", expected.full_route, route, PLAN_POINTS)
            .with_source(HORIZON)
            .with_note("computed; the full-route plan against constant speed, computed alike"),
        Row::near(&above_id, "%", requirement(0.0), above, ROUTE_POINTS)
            .with_source(HORIZON)
            .with_note("driven less the computed full-route plan, percentage points"),
        near("human_sigma_2.5", expected.humans[0], calm, HUMAN_POINTS)
            .with_source(SKILLED)
            .with_note(AGAINST),
        near("human_sigma_4", expected.humans[1], human(restless_mps), HUMAN_POINTS)
            .with_source(SKILLED)
            .with_note(AGAINST),
    ];
    (rows, other)
}

/// Stretches that steps 1 and 2 of the planner make of the road, horizon by horizon, over its cells.
pub fn stretches(preset: Preset, road: &GradeProfile) -> Option<f64> {
    let keys = RoadKeys::default();
    let limits = LimitGrades::new(&Truck::preset(preset), SET_SPEED_MPS);
    let mut reconstruction = Reconstruction::new(&keys);
    let (mut stretches, mut start_m) = (0, 0.0);
    while start_m < ROAD_M {
        let mut preview =
            Preview { start_m, cell_m: CELL_M, count: MAX_CELLS, ..Preview::default() };
        for (cell, grade) in preview.grades.iter_mut().enumerate() {
            let from_m = start_m + CELL_M * cell as f64;
            *grade = road.mean_grade(from_m, from_m + CELL_M);
        }
        reconstruction.rebuild(&preview, start_m, &limits);
        stretches += reconstruction.stretches().len();
        let length_m: f64 = reconstruction.stretches().iter().map(|stretch| stretch.length_m).sum();
        start_m += (length_m > 0.0).then_some(length_m)?;
    }
    Some(stretches as f64 * CELL_M / ROAD_M)
}

/// Distance of the planner from the full-route plan on roads of other seeds: the largest one, on either side.
pub fn on_generated(preset: Preset) -> Row {
    let above = (1..=GENERATED).map(|seed| {
        let road = generated(ROAD_M, seed);
        let comparison = Comparison::new(&Truck::preset(preset), &road, SET_SPEED_MPS)?;
        let change = |trip: Option<Trip>| Some(comparison.change_percent(&trip?));
        let planned = change(comparison.informed(PlannerKind::DynamicProgramming))?;
        Some(planned - change(comparison.bound())?)
    });
    let above = above.collect::<Option<Vec<f64>>>();
    let farthest = above.and_then(|all| all.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())));
    let id = format!("{}.dynamic-programming.above_full_route_generated", preset.name());
    Row::near(&id, "%", requirement(0.0), farthest, ROUTE_POINTS)
        .with_source(HORIZON)
        .with_note("computed; the farthest of ten generated roads, percentage points")
}

/// Fuel that the reconstruction gives for a preset: the baseline in L/100 km, then percent against it.
pub struct Reconstructed {
    pub preset: Preset,
    pub constant_speed: f64,
    /// In the order of `PLANNERS`.
    pub planners: [f64; 2],
    pub full_route: f64,
    /// Standard deviations of 2.5 and 4 km/h.
    pub humans: [f64; 2],
}

pub const RECONSTRUCTED: [Reconstructed; 2] = [
    Reconstructed {
        preset: Preset::Jh6At49T,
        constant_speed: 34.25,
        planners: [-5.05, -7.6],
        full_route: -7.8,
        humans: [1.6, 2.8],
    },
    Reconstructed {
        preset: Preset::Jh6At25T,
        constant_speed: 21.81,
        planners: [-2.15, -3.3],
        full_route: -3.4,
        humans: [2.1, 3.6],
    },
];

/// Planners against the reconstruction's, percentage points.
pub const PLAN_POINTS: Tolerance = within(
    0.3,
    "another implementation of a planner on a grid; the n = 2 scheme is given as a range 0.1 to 0.3 wide",
);

/// The paper's sentences.
pub const TEST: &str = "the test without other vehicles, at a set speed of 75 km/h";
pub const SKILLED: &str = "a skilled driver's fuel on the same road (about 22 L)";
