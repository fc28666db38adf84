//! The columns of a trajectory.

use parquet_writer::Cells;
use scenario::Scenario;
use supervise::{Drive, DriveStep};

/// Names of the columns before and behind the study's keys.
pub(super) const NAMES: [&[&str]; 2] = [
    &["run", "scenario", "law", "seed"],
    &[
        "time_s",
        "position_m",
        "speed_mps",
        "acceleration_mps2",
        "applied_mps2",
        "request_mps2",
        "gap_m",
        "lead_speed_mps",
        "mode",
        "quality",
        "gear",
        "engine_torque_nm",
        "fuel_g",
        "figure_0",
        "figure_1",
        "figure_2",
        "figure_3",
        "figure_4",
        "figure_5",
        "figure_6",
        "figure_7",
        "ttc_s",
        "stop_line_m",
        "signal",
        "brake_state",
        "lead",
        "lead_acceleration_mps2",
    ],
];

/// A key that the study varies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    pub name: String,
    /// Its values are numbers in all runs.
    pub is_number: bool,
}

/// The keys of a study by those of its runs. A key need not apply in every run.
pub fn keys(runs: impl Iterator<Item = Vec<(String, String)>>) -> Vec<Key> {
    /// A key with the kinds of values that it was seen with.
    struct Seen {
        name: String,
        number: bool,
        word: bool,
    }

    let mut keys: Vec<Seen> = Vec::new();
    for run in runs {
        if keys.is_empty() {
            let key = |(name, _): &(String, String)| Seen {
                name: name.clone(),
                number: false,
                word: false,
            };
            keys = run.iter().map(key).collect();
        }
        for (key, (_, value)) in
            keys.iter_mut().zip(&run).filter(|(_, (_, value))| !value.is_empty())
        {
            let is_number = value.parse::<f64>().is_ok();
            key.number |= is_number;
            key.word |= !is_number;
        }
    }
    keys.into_iter()
        .map(|Seen { name, number, word }| Key { name, is_number: number && !word })
        .collect()
}

/// The cells of a run, in the order of the columns.
pub(super) fn cells(
    run: usize,
    scenario: &Scenario,
    law: &str,
    keys: &[Key],
    values: &[(String, String)],
    drive: &Drive,
) -> Vec<Cells> {
    let steps = &drive.steps;
    let text = |text: &str| Cells::Text(vec![Some(text.to_owned()); steps.len()]);
    let number =
        |of: &dyn Fn(&DriveStep) -> Option<f64>| Cells::Number(steps.iter().map(of).collect());
    let whole =
        |of: &dyn Fn(&DriveStep) -> Option<i64>| Cells::Integer(steps.iter().map(of).collect());
    let mut cells = vec![
        whole(&|_| Some(run as i64)),
        text(scenario.name.as_str()),
        text(law),
        whole(&|_| i64::try_from(scenario.seed.value()).ok()),
    ];
    cells.extend(keys.iter().zip(values).map(|(key, (_, value))| match key.is_number {
        true => number(&|_| value.parse().ok()),
        false if value.is_empty() => Cells::Text(vec![None; steps.len()]),
        false => text(value),
    }));
    cells.extend([
        number(&|step| Some(step.time_s)),
        number(&|step| Some(step.position_m)),
        number(&|step| Some(step.speed_mps)),
        number(&|step| Some(step.acceleration_mps2)),
        number(&|step| Some(step.applied_mps2)),
        number(&|step| step.request_mps2),
        number(&|step| step.gap_m),
        number(&|step| step.lead_speed_mps),
        whole(&|step| step.mode.map(i64::from)),
        whole(&|step| step.quality.map(i64::from)),
        whole(&|step| step.powertrain.map(|powertrain| i64::from(powertrain.gear))),
        number(&|step| step.powertrain.map(|powertrain| powertrain.engine_torque_nm)),
        number(&|step| step.powertrain.map(|powertrain| powertrain.fuel_g)),
    ]);
    let figures = NAMES[1].iter().filter(|name| name.starts_with("figure_")).enumerate();
    let figures = figures.map(|(index, _)| number(&|step| step.figures?.get(index).copied()));
    cells.extend(figures);
    cells.extend([
        number(&|step| Some(step.time_to_collision_s).filter(|time_s| time_s.is_finite())),
        number(&|step| Some(step.stop_line_m).filter(|way_m| way_m.is_finite())),
        whole(&|step| step.signal.map(|phase| i64::from(phase.to_wire()))),
        whole(&|step| step.brake.map(|state| i64::from(state as u32))),
        whole(&|step| step.lead.map(i64::from)),
        number(&|step| step.lead_acceleration_mps2),
    ]);
    cells
}
