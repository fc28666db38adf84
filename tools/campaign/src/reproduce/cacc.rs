//! CACC through signalised intersections (He et al. 2024): scenarios A, B, C and Table 3 under both
//! controllers, once with one set of weights for all and once with the sets fitted to each.

use super::row::Row;
use super::{Driven, Runner};
use controller::laws::cacc::published::{self, Calibration, Runs, Trajectory};
use controller::laws::cacc::weights::{self, Weights};
use group::Error;

/// Scenarios driven.
pub const RUNS: usize = 14;

/// Lead acceleration of Table 3 that goes with the weights fitted to it, m/s².
const TABLE_3_LEAD: &str = "actors.0.profile.steps.0.acceleration_mps2=2.594";

pub fn reproduce(runner: &mut Runner<'_>) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for calibration in [Calibration::Joint, Calibration::Single] {
        let recorded = record(runner, calibration)?;
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
        rows.extend(published::rows(&runs, calibration).into_iter().map(|row| Row {
            id: row.id.into(),
            weights: Some(row.weights.to_string()),
            unit: row.unit,
            paper: Some(row.paper),
            ours: row.ours,
            tolerance: Some(row.tolerance),
            ok: row.ok,
            note: None,
        }));
    }
    Ok(rows)
}

/// Drives all scenarios in the order of [`Runs`].
fn record(runner: &mut Runner<'_>, calibration: Calibration) -> Result<Vec<Recorded>, Error> {
    let single = calibration == Calibration::Single;
    let fitted = |weights: Weights| if single { weight_keys(&weights) } else { Vec::new() };
    let mut record = |scenario: &str, controller: &str, mut keys: Vec<String>| {
        keys.push(format!("controller.name={controller}"));
        let keys: Vec<_> = keys.iter().map(String::as_str).collect();
        runner.drive(scenario, &keys).map(|driven| Recorded::new(&driven))
    };
    let a = fitted(weights::SCENARIO_A);
    let c = fitted(weights::SCENARIO_C);
    let mut t3 = fitted(weights::TABLE_3);
    if single {
        t3.push(TABLE_3_LEAD.into());
    }
    Ok(vec![
        record("cacc-a", "acc-mpc", a.clone())?,
        record("cacc-a", "cacc-mpc", a.clone())?,
        record("cacc-b", "cacc-mpc", a)?,
        record("cacc-c", "acc-mpc", c.clone())?,
        record("cacc-c", "cacc-mpc", c)?,
        record("cacc-table3", "acc-mpc", t3.clone())?,
        record("cacc-table3", "cacc-mpc", t3)?,
    ])
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
