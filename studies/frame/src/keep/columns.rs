//! The columns of a trajectory.

use parquet_writer::Cells;
use report::trajectory::{COLUMNS, LATER, StepColumn};
use scenario::Scenario;
use supervise::{Drive, DriveStep};

/// Figures of the law that a step has room for.
const FIGURES: usize = 8;

/// Names of the columns: of the run with the study's keys, then of a step.
pub(super) fn names(keys: &[Key]) -> Vec<String> {
    let of_run = ["run", "scenario", "law", "seed"].into_iter().map(str::to_owned);
    let of_step = |columns: &[StepColumn]| -> Vec<String> {
        columns.iter().map(|(name, ..)| (*name).to_owned()).collect()
    };
    let figures = (0..FIGURES).map(|place| format!("figure_{place}"));
    let keys = keys.iter().map(|key| key.name.clone());
    of_run.chain(keys).chain(of_step(&COLUMNS)).chain(figures).chain(of_step(&LATER)).collect()
}

/// A key that the study varies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    pub name: String,
    /// Its values are numbers in all runs.
    pub is_number: bool,
}

/// The keys of a study by those of its runs. A key need not apply in every run.
pub fn keys(runs: impl Iterator<Item = Vec<(String, String)>>) -> Vec<Key> {
    // Each key, and whether numbers and words were seen as its values.
    let mut seen: Vec<(String, bool, bool)> = Vec::new();
    for run in runs {
        if seen.is_empty() {
            seen = run.iter().map(|(name, _)| (name.clone(), false, false)).collect();
        }
        for ((_, number, word), (_, value)) in seen.iter_mut().zip(&run) {
            let is_number = value.parse::<f64>().is_ok();
            *number |= is_number;
            *word |= !is_number && !value.is_empty();
        }
    }
    let key = |(name, number, word): (String, bool, bool)| Key { name, is_number: number && !word };
    seen.into_iter().map(key).collect()
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
    let of_step = |(_, is_whole, value): &StepColumn| match is_whole {
        true => whole(&|step| value(step).map(|value| value as i64)),
        false => number(value),
    };
    cells.extend(COLUMNS.iter().map(of_step));
    cells.extend((0..FIGURES).map(|place| number(&|step| step.figures?.get(place).copied())));
    cells.extend(LATER.iter().map(of_step));
    cells
}
