//! CACC through signalised intersections (He et al. 2024): scenarios A, B, C and Table 3 under both
//! controllers, once with one set of weights for all and once with the sets fitted to each.

use super::row::{Row, paper, within};
use super::runner::{Driven, Part, Runner, together};
use controller::laws::cacc::published::{self, Calibration, Kind, Runs, Trajectory};
use controller::laws::cacc::weights::{self, Weights};
use group::Error;
use report::RunPicture;

/// Scenarios driven.
pub const RUNS: usize = 14;

/// Lead acceleration of Table 3 that goes with the weights fitted to it, m/s².
const TABLE_3_LEAD: &str = "actors.0.profile.steps.0.acceleration_mps2=2.594";

/// Drives the scenarios with both sets of weights and compares.
pub fn reproduce(runner: &Runner<'_>) -> Result<Part, Error> {
    let calibrations = [Calibration::Joint, Calibration::Single];
    let recorded = together(calibrations.map(|calibration| move || record(runner, calibration)));
    let mut part = Part::default();
    for (calibration, recorded) in calibrations.into_iter().zip(recorded) {
        let (recorded, drives): (Vec<_>, Vec<_>) = recorded?.into_iter().unzip();
        part.drives.extend(drives);
        let run = |index: usize| Some(recorded[index].trajectory());
        let runs = Runs {
            a_acc: run(0),
            a_cacc: run(1),
            b_cacc: run(2),
            c_acc: run(3),
            c_cacc: run(4),
            t3_acc: run(5),
            t3_cacc: run(6),
        };
        for row in published::rows(&runs, calibration) {
            let tolerance = within(row.tolerance, reason(row.id));
            let row_of_paper = Row::near(row.id, row.unit, paper(row.paper), row.ours, tolerance);
            part.rows.push(row_of_paper.in_set(&format!("{calibration} weights")));
        }
    }
    Ok(part)
}

/// Why a figure's tolerance is that large.
fn reason(id: &str) -> &'static str {
    let figure = published::FIGURES.iter().find(|figure| figure.id == id);
    match figure.map(|figure| figure.kind) {
        Some(Kind::Crossing) => {
            "the weights are not printed; a quarter of a second, fitted ones 0.1 s"
        }
        Some(Kind::Distance) => "the weights are not printed; 3 m, fitted ones 1 m",
        Some(Kind::Speed) => "read from a plot: a third of what distances are held to",
        Some(Kind::Duration) => "read from a plot: twice what crossing times are held to",
        Some(Kind::Boolean) | None => "exact",
    }
}

/// A recorded drive, and its picture under its name.
type Recording = (Recorded, (String, RunPicture));

/// Drives all scenarios in the order of [`Runs`].
fn record(runner: &Runner<'_>, calibration: Calibration) -> Result<Vec<Recording>, Error> {
    let single = calibration == Calibration::Single;
    let fitted = |weights: Weights| if single { weight_keys(&weights) } else { Vec::new() };
    let a = fitted(weights::SCENARIO_A);
    let c = fitted(weights::SCENARIO_C);
    let mut t3 = fitted(weights::TABLE_3);
    if single {
        t3.push(TABLE_3_LEAD.into());
    }
    let drives = [
        ("cacc-a", "acc-mpc", &a),
        ("cacc-a", "cacc-mpc", &a),
        ("cacc-b", "cacc-mpc", &a),
        ("cacc-c", "acc-mpc", &c),
        ("cacc-c", "cacc-mpc", &c),
        ("cacc-table3", "acc-mpc", &t3),
        ("cacc-table3", "cacc-mpc", &t3),
    ];
    let driven = together(drives.map(|(scenario, controller, keys)| {
        move || {
            let name = format!("controller.name={controller}");
            let keys: Vec<_> = keys.iter().map(String::as_str).chain([name.as_str()]).collect();
            let driven = runner.drive(scenario, &keys)?;
            Ok((Recorded::new(&driven), driven.picture()))
        }
    }));
    driven.into_iter().collect()
}

fn weight_keys(weights: &Weights) -> Vec<String> {
    [
        ("q1", weights.gap_error_per_m2),
        ("q2", weights.speed_error_s2_per_m2),
        ("q3", weights.acceleration_s4_per_m2),
        ("r", weights.request_s4_per_m2),
        ("light_weight", weights.light_m),
        ("light_threshold_m", weights.light_threshold_m),
    ]
    .iter()
    .map(|(key, value)| format!("controller.weights.{key}={value:?}"))
    .collect()
}

/// A drive at its control cycles, column by column.
struct Recorded {
    columns: [Vec<f64>; 8],
}

impl Recorded {
    fn new(driven: &Driven) -> Self {
        let errors = driven.figure("gap_error_m").into_iter().zip(driven.figure("speed_error_mps"));
        let cycles = driven.drive.steps.iter().filter(|step| step.figures.is_some());
        let mut columns: [Vec<f64>; 8] = Default::default();
        for (step, ((_, gap_error), (_, speed_error))) in cycles.zip(errors) {
            let row = [
                step.time_s,
                step.position_m,
                step.speed_mps,
                step.acceleration_mps2,
                step.request_mps2.unwrap_or(f64::NAN),
                gap_error,
                speed_error,
                step.gap_m.unwrap_or(f64::NAN),
            ];
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        Self { columns }
    }

    fn trajectory(&self) -> Trajectory<'_> {
        let [
            time_s,
            position_m,
            speed_mps,
            acceleration_mps2,
            request_mps2,
            gap_error_m,
            speed_error_mps,
            gap_m,
        ] = &self.columns;
        Trajectory {
            time_s,
            position_m,
            speed_mps,
            acceleration_mps2,
            request_mps2,
            gap_error_m,
            speed_error_mps,
            gap_m,
        }
    }
}
